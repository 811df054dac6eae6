"""Custom properties for sunfleck (docs/scene-format.md, "glTF"), from Blender's settings and the add-on's.

Invariant: every property here is a plain dictionary of numbers, texts and lists. A property written by
hand is kept, unless the panel sets the same one.
"""

from pathlib import Path
from urllib.parse import quote

from . import film, fog, world
from .evaluated import lights
from .evaluated.moments import OFFSETS
from .materials.colours import rec709
from .stored import fields_by_hand, is_by_hand, put

# Shapes of Blender's area lights in sunfleck.
AREA_SHAPES = {"SQUARE": "square", "RECTANGLE": "rectangle", "DISK": "disk", "ELLIPSE": "ellipse"}


# Minimum focus distance, metres, as in Cycles; and f-stop, where nothing is left to see.
LEAST_FOCUS_M, LEAST_F_STOP = 1e-5, 1e-3
# Smaller than the smallest half, and negligible beside any light.
NEXT_TO_BLACK = 1e-30
LOOKS = {f"AgX - {look.replace('-', ' ').title()}": look for look in (
    "very-high-contrast", "high-contrast", "medium-high-contrast", "medium-low-contrast", "low-contrast", "very-low-contrast",
    "punchy", "greyscale")}
# Looks without an effect.
PLAIN_LOOKS = {"None", "AgX - Base Contrast"}


def look(view):
    """Sunfleck's name of Blender's look."""
    return LOOKS.get(view.look, "none") if view.view_transform == "AgX" else "none"


def is_shown_alike(view):
    """Whether sunfleck's display matches Blender's."""
    plain = view.gamma == 1.0 and not view.use_curve_mapping and not getattr(view, "use_white_balance", False)
    return plain and view.view_transform == "AgX" and view.look in {*PLAIN_LOOKS, *LOOKS}


def of_scene(scene, path=None):
    """Custom properties of the scene; images are written beside `path`."""
    found = {"sunfleck": settings(scene), "sunfleck_fog": fog_everywhere(scene), "sunfleck_env": sky(scene, path)}
    return {name: said for name, said in found.items() if said}


def settings(scene):
    """Frames, picture, and how it is rendered."""
    own, render = scene.sunfleck_settings, scene.render
    percent = render.resolution_percentage / 100.0
    sunfleck = {
        "version": 1,
        "fps": float(render.fps),
        "fps_base": float(render.fps_base),
        "frame_start": scene.frame_start,
        "frame_end": scene.frame_end,
        # Pixels are square; other aspects change their number.
        "resolution": [max(1, round(side * percent)) for side in picture_sides(scene)],
        "light_units": "spec",
        "filter": own.filter,
        "exposure": scene.view_settings.exposure,
        "look": look(scene.view_settings),
        "seed": own.seed,
        "passes": sorted(own.passes),
        "bounces": "all" if own.all_bounces else own.bounces,
        "shutter": 0.0,
    }
    if own.use_samples:
        sunfleck["samples"] = own.samples
    else:
        sunfleck["tolerance"] = own.tolerance
    if scene.camera:
        sunfleck["camera"] = scene.camera.name
    if render.use_motion_blur:
        shutter = render.motion_blur_shutter
        sunfleck["shutter"], sunfleck["shutter_offset"] = shutter, OFFSETS[render.motion_blur_position] * shutter
    return sunfleck


def fog_everywhere(scene):
    """The panel's, else the world's volume; None without either."""
    own = scene.sunfleck_settings
    if own.use_fog:
        return {**fog.of_settings(own), "scale_height": own.scale_height, "base_height": own.base_height}
    return fog.of_world(scene)


def sky(scene, path):
    """The world, or the panel's background; None without either."""
    own, found = scene.sunfleck_settings, None
    if world.is_sky(scene):
        found = world.of_world(scene, path)
    elif own.background_strength > 0.0:
        found = {"color": list(rec709(tuple(own.background_color))), "strength": own.background_strength}
    is_black = world.is_sky(scene) or not (world.shines(scene) or world.is_baked(scene))
    if found is None and is_black and not is_by_hand(scene, "sunfleck_env"):
        # Otherwise the program adds default light.
        found = {"color": [0.0] * 3, "strength": 0.0}
    if found is None:
        return None
    for one in (found, found.get("backdrop", {"strength": 0.0})):
        one["strength"] *= film.exposure(scene)
    is_dark, is_opaque = max(found.get("color", [1.0])) * found["strength"] == 0.0, not scene.render.film_transparent
    if is_dark and is_opaque and world.is_sky(scene) and "backdrop" not in found:
        # A visible background, so that the film is not transparent.
        found = {"color": [NEXT_TO_BLACK] * 3, "strength": 1.0, "lights": "nothing"}
    unseen = {} if is_opaque else {"visible_to_camera": False}
    if not is_opaque:
        found.pop("backdrop", None)
    return {"lights": world.lights(scene), **found, **unseen}


def of_object(thing, scene, path=None, exposure=None, scale=None):
    """Custom properties of an object in a scene; images are written beside `path`. Light is times `exposure`, else the scene's.
    An instance has a `scale` of its own."""
    own, written = thing.sunfleck_settings, {}
    if own.is_fog:
        volume = {"shape": "box", **fog.numbers(thing)}
        if own.thins_out:
            volume["scale_height"] = own.scale_height
        if own.use_mist:
            volume["mist"] = fog.mist(own)
        written["sunfleck_fog_volume"] = volume
    if own.use_leaf_id:
        written["leaf_id"] = own.leaf_id
    if thing.type == "LIGHT":
        exposure = film.exposure(scene) if exposure is None else exposure
        written["sunfleck_light"] = {**fields_by_hand(thing, "sunfleck_light"), **light(thing, exposure, scale)}
        if thing.data.type == "SUN" and own.sun_shows == "IMAGE" and own.sun_image and path is not None:
            name = world.on_the_sun(own.sun_image, Path(path), thing.name_full)
            written["sunfleck_light"]["image"] = quote(name)
    return written


def light(thing, exposure, scale=None):
    """Properties of a light that glTF lacks, times `exposure`."""
    data, own = thing.data, thing.sunfleck_settings
    strength = exposure * lights.power_w(data, thing.matrix_world.to_scale() if scale is None else scale)
    if data.type == "SUN":
        said = {"angle": data.angle, "strength_w_m2": strength, **sun_disc(own)}
        return {**said, "visible_to_camera": True} if own.visible_to_camera else said
    if data.type == "AREA":
        return {
            "type": "area", "shape": AREA_SHAPES[data.shape], "size": lights.written_size(data), "power_w": strength,
            "color": list(lights.color(data)), "spread": lights.spread(data), **seen_by(thing),
        }
    falloff = {"soft_falloff": data.use_soft_falloff, "shines_inward": data.type == "POINT" and not data.use_soft_falloff}
    return {"radius": data.shadow_soft_size, "power_w": strength, **falloff, **seen_by(thing)}


def seen_by(lamp):
    return {"visible_to_camera": lamp.visible_camera, "visible_in_mirrors": lamp.visible_glossy}


def sun_disc(own):
    """Picture of a sun's disc without an image, which has to be written beside the file."""
    said = {"limb_darkening": own.limb_darkening} if own.limb_darkening > 0.0 else {}
    if own.sun_shows == "FRACTAL":
        said["fractal"] = {
            "real": own.fractal_real, "imaginary": own.fractal_imaginary, "iterations": own.fractal_iterations
        }
    if own.sun_shows != "EVEN":
        said["picture_rotation"] = own.picture_rotation
    return said


def of_camera(data, scene, eye=None):
    """Properties of a camera that glTF lacks; `eye` is its object, if known."""
    written = {"sensor_width_mm": sensor_width_mm(data, scene)}
    shift = shift_of_longer_side(data, scene)
    if shift != [0.0, 0.0]:
        written["shift"] = shift
    if data.dof.use_dof and data.type != "ORTHO":
        written["fstop"] = f_stop(data)
        written["focus_distance"] = focus_distance(data, scene, eye)
        if data.dof.aperture_blades >= 3:
            written["blades"] = data.dof.aperture_blades
    return {"sunfleck_camera": written}


def picture_sides(scene):
    """Width and height of the picture in units of one pixel's height."""
    render = scene.render
    return render.resolution_x * render.pixel_aspect_x / render.pixel_aspect_y, float(render.resolution_y)


def fitted_side(data, scene):
    """Side of the picture that the sensor's size and the shift refer to."""
    width, height = picture_sides(scene)
    if data.sensor_fit == "AUTO":
        return max(width, height)
    return width if data.sensor_fit == "HORIZONTAL" else height


def sensor_width_mm(data, scene):
    """Width of the sensor under the picture's width, from which sunfleck computes the focal length."""
    width, _ = picture_sides(scene)
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    return sensor * width / fitted_side(data, scene)


def shift_of_longer_side(data, scene):
    """Lens shift as a fraction of the picture's longer side."""
    scale = fitted_side(data, scene) / max(picture_sides(scene))
    return [data.shift_x * scale, data.shift_y * scale]


def f_stop(data):
    return max(LEAST_F_STOP, data.dof.aperture_fstop)


def focus_distance(data, scene, eye=None):
    """Distance along the view to the plane in focus, metres; before the camera also if its object is behind."""
    target = data.dof.focus_object
    eye = eye or next((thing for thing in scene.objects if thing.type == "CAMERA" and thing.data == data), None)
    if target is None or eye is None:
        return max(LEAST_FOCUS_M, data.dof.focus_distance)
    bone = target.pose.bones.get(data.dof.focus_subtarget) if target.pose else None
    place = target.matrix_world @ bone.matrix if bone else target.matrix_world
    return max(LEAST_FOCUS_M, abs((eye.matrix_world.normalized().inverted() @ place.translation).z))


def of_material(material):
    """Properties of a material that glTF lacks."""
    own = material.sunfleck_settings
    if not own.is_leaf:
        return {}
    leaf = {"translucency": own.translucency}
    if own.use_transmit_color:
        leaf["transmit_color"] = list(own.transmit_color)
    return {"sunfleck_leaf": leaf}


def store(scene, path=None):
    """Writes all properties, and images beside the future file."""
    put(scene, of_scene(scene, path))
    for thing in scene.objects:
        put(thing, of_object(thing, scene, path))
        if thing.type == "CAMERA":
            put(thing.data, of_camera(thing.data, scene))
        for slot in thing.material_slots:
            if slot.material:
                put(slot.material, of_material(slot.material))
