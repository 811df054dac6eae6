"""World. In go its nodes, out comes the custom property `sunfleck_env`.

A sky is a uniform colour, an environment texture, or a baked picture of other nodes. Images are written
beside the exported file, as those on suns. Invariant: the sky is the world at the current frame.
"""

import math
import re
import shutil
import zlib
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import quote

import bpy

from . import keys, world_picture, world_rays, world_sun
from .film import ENGINE
from .materials import dependence, principled
from .materials.colours import rec709
from .materials.images import IN_SRGB
from .materials.links import link_to
from .materials.pictures import is_moved

# Blender has +X in the centre of the image, sunfleck +Y (glTF's -Z).
QUARTER_TURN = -0.5 * math.pi
# Width in texels from which a bake would be coarser than the picture.
FINE = 1024
READ_AS_IT_IS = {".hdr", ".exr"}
COLOURS_READ_AS_THEY_ARE = {".png", ".jpg", ".jpeg", ".webp"}


def backgrounds(scene):
    """Background shaders of the world."""
    tree = scene.world and scene.world.node_tree
    return [node for node in tree.nodes if node.type == "BACKGROUND"] if tree else []


def surface_link(scene):
    """Link to the world's surface; None without one."""
    return principled.surface_link(scene.world) if scene.world else None


def shines(scene):
    """Whether the world has any radiance."""
    return surface_link(scene) is not None and any(
        node.inputs["Strength"].default_value > 0.0
        and (node.inputs["Color"].is_linked or max(node.inputs["Color"].default_value[:3]) > 0.0)
        for node in backgrounds(scene)
    )


def volume_of(scene):
    """Volume socket of the world, if anything is linked to it."""
    tree = scene.world and scene.world.node_tree
    output = tree.get_output_node("CYCLES") if tree else None
    return output.inputs["Volume"] if output and output.inputs["Volume"].is_linked else None


def is_plain(scene):
    """Whether it is one colour or one environment texture, which needs no baking."""
    shaders, link = backgrounds(scene), surface_link(scene)
    if link is None or [link.from_node] != shaders or shaders[0].inputs["Strength"].is_linked:
        return False
    if not shaders[0].inputs["Color"].is_linked:
        return True
    texture = environment(shaders[0])
    if texture is None or texture.projection != "EQUIRECTANGULAR" or turn(texture) is None or is_moved(texture) or texture.image.source in dependence.FILMS:
        return False
    # Cycles smooths what is stored, and radiances are between texels here.
    is_smooth = texture.interpolation == "Linear" and texture.image.colorspace_settings.name not in IN_SRGB
    return is_smooth or max(texture.image.size) > FINE


def is_baked(scene):
    """Whether it needs baking."""
    return surface_link(scene) is not None and not is_plain(scene)


def changes(scene):
    """Whether it is keyed or driven, shows a film, or an object of its nodes may move."""
    return keys.changes(scene.world) or (scene.world is not None and dependence.is_of_film(scene.world))


def depends_on_rays(scene):
    """Whether the camera sees another world than surfaces, or it depends on the camera."""
    return any(map(tells_rays_apart, dependence.nodes_of(scene.world)))


def tells_rays_apart(node):
    return dependence.LOST.get(node.type) == dependence.VIEW or dependence.is_asked_of_view(node)


def is_split(scene):
    """Whether the camera sees another world than surfaces, and that is the only dependence."""
    if not (scene.world and scene.world.node_tree and lights(scene) != "nothing" and world_rays.tells_camera_apart(scene.world)):
        return False
    asking = [node for node in dependence.nodes_of(scene.world) if tells_rays_apart(node)]
    return all(node.type == "LIGHT_PATH" and node.id_data == scene.world.node_tree for node in asking)


def of_world(scene, path):
    """`sunfleck_env` without `lights`, with images written beside `path`; `None` without a world, or if
    they cannot be written."""
    if not is_split(scene):
        return of_one(scene, path)
    found = []
    for is_camera, stem in ((False, ""), (True, "_backdrop")):
        with world_rays.seen_by(scene.world, is_camera) as world:
            stand_in = SimpleNamespace(
                world=world, sunfleck_settings=scene.sunfleck_settings, render=scene.render, frame_current_final=scene.frame_current_final)
            beside = path and Path(path).with_stem(Path(path).stem + stem)
            found.append(of_one(stand_in, beside) or {"color": [0.0, 0.0, 0.0], "strength": 1.0})
    return {**found[0], "backdrop": found[1]}


def of_one(scene, path):
    """The same for a world that is equal for all rays."""
    if not is_plain(scene):
        if path is None or not is_baked(scene):
            return None
        with world_sun.without_disc(scene.world) if has_sun(scene) else nullcontext(scene.world) as shown:
            name = world_picture.beside(shown, scene.frame_current_final, Path(path))
        if world_picture.is_black_file(Path(path).with_name(name)):
            return {"color": [0.0] * 3, "strength": 1.0}
        return {"image": quote(name), "strength": 1.0, "rotation": 0.0}
    shader = backgrounds(scene)[0]
    color, strength = shader.inputs["Color"], shader.inputs["Strength"].default_value
    if not color.is_linked:
        return {"color": list(rec709(tuple(color.default_value[:3]))), "strength": strength}
    if path is None:
        return None
    texture = environment(shader)
    if world_picture.is_black(texture.image):
        return {"color": [0.0] * 3, "strength": strength}
    image = quote(written(texture.image, Path(path)))
    return {"image": image, "strength": strength, "rotation": QUARTER_TURN + turn(texture)}


# With the add-on's engine, the world is the sky unless the panel says otherwise.
SAYS_SKY = ("use_world", "background_strength", "sky_lights")


def is_left_to_blender(scene):
    """Whether the sky follows the world by default."""
    own = scene.sunfleck_settings
    return scene.render.engine == ENGINE and not any(map(own.is_property_set, SAYS_SKY))


def is_sky(scene):
    """Whether the world is the sky."""
    return scene.sunfleck_settings.use_world or is_left_to_blender(scene)


def lights(scene):
    """Contents of the scene that the sky lights."""
    return "surfaces_and_fog" if is_left_to_blender(scene) else scene.sunfleck_settings.sky_lights


def has_sun(scene):
    """Whether the disc of its Sky Texture is exported as a sun."""
    is_light = is_sky(scene) and lights(scene) != "nothing" and not is_split(scene)
    return is_light and world_sun.disc_of(scene.world) is not None


def smears_disc(scene):
    """Whether a disc stays in the picture."""
    tree = scene.world and scene.world.node_tree
    return bool(tree and world_sun.discs_in(tree)) and not has_sun(scene)


def environment(background):
    """Environment texture of a background, if it has only that."""
    links = background.inputs["Color"].links
    node = links[0].from_node if links else None
    return node if node and node.type == "TEX_ENVIRONMENT" and node.image and 0 not in node.image.size else None


def turn(texture):
    """Rotation of the picture, anticlockwise from above; `None` for other mappings."""
    link = link_to(texture.inputs["Vector"])
    if link is None or is_direction(link):
        return 0.0
    node = link.from_node
    inner = link_to(node.inputs["Vector"]) if node.type == "MAPPING" and not node.mute else None
    is_still = inner is not None and not any(node.inputs[name].is_linked for name in ("Location", "Rotation", "Scale"))
    if not is_still or not is_direction(inner):
        return None
    x, y, z = node.inputs["Rotation"].default_value
    location, scale = node.inputs["Location"].default_value, node.inputs["Scale"].default_value
    if max(abs(x), abs(y), *map(abs, location), *(abs(s - 1.0) for s in scale)) > 1e-6:
        return None
    # A rotation of directions is the inverse rotation of the picture.
    return z if node.vector_type == "TEXTURE" else -z


def is_direction(link):
    """Whether it gives the view direction."""
    return link.from_node.type == "TEX_COORD" and link.from_socket.name == "Generated"


def copied(source, beside):
    """Name of a copy of the file."""
    if not (beside.exists() and beside.samefile(source)):
        shutil.copyfile(source, beside)
    return beside.name


def on_the_sun(image, path, name):
    """Name of a file beside `path` with the image of the sun `name`, unchanged."""
    plain = re.sub(r"[^A-Za-z0-9]+", "_", name)
    # Names of other scripts would all be the same.
    stem = f"{path.stem}_{plain}" + ("" if plain == name else f"_{zlib.crc32(name.encode()):08x}")
    source = source_of(image)
    if source and source.suffix.lower() in COLOURS_READ_AS_THEY_ARE:
        return copied(source, path.with_name(f"{stem}{source.suffix.lower()}"))
    beside = path.with_name(f"{stem}.png")
    before = image.file_format
    try:
        image.file_format = "PNG"
        image.save(filepath=str(beside), save_copy=True)
    finally:
        image.file_format = before
    return beside.name


def source_of(image):
    """The image's own file, if it holds the same pixels."""
    if image.source != "FILE" or image.packed_file or not image.filepath or image.is_dirty:
        return None
    return Path(image.filepath_from_user())


def written(image, path):
    """Name of a file beside `path` with the image's radiances."""
    source = source_of(image)
    if source and source.suffix.lower() in READ_AS_IT_IS and image.colorspace_settings.name == "Linear Rec.709":
        return copied(source, path.with_name(f"{path.stem}_sky{source.suffix.lower()}"))
    beside = path.with_name(f"{path.stem}_sky.exr")
    settings_of = bpy.data.scenes.new("sunfleck image")
    try:
        settings = settings_of.render.image_settings
        settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
        image.save_render(str(beside), scene=settings_of)
    finally:
        bpy.data.scenes.remove(settings_of)
    return beside.name
