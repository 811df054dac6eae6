"""Makes scenes/blender_glade/glade.glb in Blender: a clearing with one oak, its leaves in the wind,
which a simulation zone lets go, blows about and lays on the ground (glade_wind.py).

    PYTHONPATH=tools/blender python tools/blender/examples/glade.py [GLB]

needs `pip install bpy`, and the meshes and textures of scenes/woods. Everything after the imports is what an
artist does with the mouse: place meshes, build nodes, key the camera, set the add-on's properties, export.
The same versions of Blender and of this file write the same scene.
"""

import math
import random
import sys
from pathlib import Path
from typing import NamedTuple

import bpy
import mathutils

import glade_wind
import sunfleck
from sunfleck import command

ROOT = Path(__file__).resolve().parents[3]
WOODS = ROOT / "scenes" / "woods"
FRAMES = (1, 72)


def start():
    """An empty scene with the add-on on."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    sunfleck.register()
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAMES
    scene.render.fps = 24
    scene.render.resolution_x, scene.render.resolution_y = 1280, 720
    scene.render.resolution_percentage = 100
    return scene


def material(name, texture, translucency=None, factor=1.0):
    """A matte material with a picture; leaves let light through."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"]
    shader.inputs["Specular IOR Level"].default_value = 0.0
    shader.inputs["Roughness"].default_value = 1.0
    picture = nodes.new("ShaderNodeTexImage")
    picture.image = bpy.data.images.load(str(WOODS / "textures" / texture), check_existing=True)
    if factor == 1.0:
        links.new(picture.outputs["Color"], shader.inputs["Base Color"])
    else:
        mix = nodes.new("ShaderNodeMix")
        mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
        mix.inputs["Factor"].default_value = 1.0
        mix.inputs["B"].default_value = (factor, factor, factor, 1.0)
        links.new(picture.outputs["Color"], mix.inputs["A"])
        links.new(mix.outputs["Result"], shader.inputs["Base Color"])
    if translucency is not None:
        made.sunfleck_settings.is_leaf = True
        made.sunfleck_settings.translucency = translucency
    return made


def mesh(name, shade):
    """A mesh of scenes/woods, y up in its file and z up here."""
    bpy.ops.wm.obj_import(filepath=str(WOODS / "meshes" / f"{name}.obj"))
    thing = bpy.context.selected_objects[0]
    data = thing.data
    data.transform(thing.matrix_basis)
    bpy.data.objects.remove(thing)
    data.materials.clear()
    data.materials.append(shade)
    return data


def place(name, data, location=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0), size=1.0):
    """An object that shows a mesh."""
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    thing.location, thing.rotation_euler, thing.scale = location, turn, (size, size, size)
    return thing


class Twigs(NamedTuple):
    """Of a tree."""

    mesh: bpy.types.Mesh
    world_from_mesh: mathutils.Matrix


def crown(name, twigs, count, leaves, rng):
    """So many leaves that hang from twigs' vertices; `leaves` are a few meshes that all share, and the smallest
    and largest size."""
    for number in range(count):
        shown, world_from_leaf = hanging_leaf(twigs, leaves, rng)
        place(f"{name} {number}", shown).matrix_basis = world_from_leaf


def hanging_leaf(twigs, leaves, rng):
    """One of the meshes, and its place at a vertex of the twigs."""
    meshes, sizes = leaves
    shown, size = rng.choice(meshes), rng.uniform(*sizes)
    location = twigs.world_from_mesh @ rng.choice(twigs.mesh.vertices).co
    droop, roll = math.radians(rng.uniform(-10, 80)), math.radians(rng.uniform(-50, 50))
    turn = mathutils.Euler((-droop, roll, rng.uniform(0, math.tau)))
    return shown, mathutils.Matrix.LocRotScale(location, turn, (size, size, size))


def crown_mesh(name, twigs, count, leaves, rng):
    """The same as one mesh, of which trees far off have one each."""
    points, faces, uvs, shades = [], [], [], []
    materials = [shown.materials[0] for shown in leaves[0]]
    for _ in range(count):
        shown, tree_from_leaf = hanging_leaf(twigs, leaves, rng)
        first = len(points)
        points.extend(tree_from_leaf @ vertex.co for vertex in shown.vertices)
        faces.extend([first + vertex for vertex in polygon.vertices] for polygon in shown.polygons)
        uvs.extend(coordinate for corner in shown.uv_layers[0].data for coordinate in corner.uv)
        shades.extend([materials.index(shown.materials[0])] * len(shown.polygons))
    data = bpy.data.meshes.new(name)
    data.from_pydata(points, [], faces)
    data.uv_layers.new().data.foreach_set("uv", uvs)
    for shade in materials:
        data.materials.append(shade)
    data.polygons.foreach_set("material_index", shades)
    return data


def group(name, things):
    """A collection outside of the scene, of what others show or strike."""
    made = bpy.data.collections.new(name)
    for thing in things:
        made.objects.link(thing)
    return made


def aloft(count, rng):
    """A mesh whose vertices are leaves that fall already as the film begins: all over the clearing, and where
    the lens is sharp."""
    points = []
    for number in range(count):
        if number % 4 == 0:
            points.append((rng.uniform(-2.6, 2.0), rng.uniform(-5.6, -2.5), rng.uniform(0.5, 3.4)))
        else:
            points.append((rng.uniform(-8.0, 5.0), rng.uniform(-4.0, 9.0), rng.uniform(0.4, 7.0)))
    data = bpy.data.meshes.new("aloft")
    data.from_pydata(points, [], [])
    return place("aloft", data)


def beyond(bark, twig, leaves, rng):
    """A wood that fades into the fog, and bushes before it; trees of a kind share meshes."""
    trees = [(7.5, 16.0), (-8.5, 19.0), (3.4, 24.0), (13.0, 27.0), (-3.5, 29.0), (-14.0, 27.0)]
    trees += [(5.8 * i - 32.0 + rng.uniform(-2.2, 2.2), rng.uniform(36.0, 44.0)) for i in range(12)]
    bushes = [(4.0 * i - 34.0 + rng.uniform(-1.5, 1.5), rng.uniform(28.0, 34.0)) for i in range(18)]
    kinds = (("birch", trees, 2400, (1.2, 1.6)), ("sapling", bushes, 320, (1.0, 1.6)))
    for kind, places, count, sizes in kinds:
        wood, fine = mesh(f"{kind}_wood", bark), mesh(f"{kind}_twigs", twig)
        of_kind = Twigs(fine, mathutils.Matrix())
        crown = crown_mesh(f"{kind} crown", of_kind, count, (leaves, (0.22, 0.34)), rng)
        for i, (x, y) in enumerate(places):
            turn, size = (0.0, 0.0, rng.uniform(0, math.tau)), rng.uniform(*sizes)
            for what, data in (("wood", wood), ("twigs", fine), ("crown", crown)):
                place(f"{kind} {what} {i + 1}", data, (x, y, 0.0), turn, size)


def falling(twigs, solid, shades, rng):
    """Leaves in the wind (glade_wind.py)."""
    shown = []
    for name, shade in (
        ("maple_far", shades[0]),
        ("maple_far_b", shades[1]),
        ("maple_far_c", shades[0]),
        ("maple_far_d", shades[1]),
    ):
        shown.append(bpy.data.objects.new(name, mesh(name, shade)))
    glade_wind.blow(aloft(260, rng), twigs, group("falling leaves", shown), group("solid", solid), 40.0)


def light_and_fog(scene):
    """A low sun from the side, morning fog that thins out, a blue sky that lights the shade."""
    data = bpy.data.lights.new("sun", "SUN")
    data.energy, data.color, data.angle = 13.0, (1.0, 0.48, 0.075), math.radians(1.2)
    sun = place("sun", data)
    sun.sunfleck_settings.visible_to_camera = True
    sun.rotation_euler = mathutils.Vector((0.30, -0.80, -0.36)).to_track_quat("-Z", "Y").to_euler()
    settings = scene.sunfleck_settings
    fog = place("fog", None, (0.0, 20.0, 10.0))
    fog.scale = (24.0, 32.0, 13.0)
    holds = fog.sunfleck_settings
    holds.is_fog, holds.density, holds.albedo, holds.anisotropy = True, 0.013, (0.96, 0.95, 0.93), 0.75
    holds.thins_out, holds.scale_height = True, 4.5
    settings.background_color, settings.background_strength = (0.17, 0.7, 1.0), 0.18
    settings.sky_lights = "surfaces_and_fog"
    settings.tolerance, settings.passes = 0.04, set()


def camera(scene):
    """Close to the ground, moving in slowly; leaves in the air at hand are in focus."""
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.lens = "HORIZONTAL", 26.0
    data.dof.use_dof, data.dof.focus_distance, data.dof.aperture_fstop = True, 4.6, 2.8
    thing = place("camera", data)
    for frame, location in ((FRAMES[0], (0.6, -7.6, 0.85)), (FRAMES[1], (0.2, -6.9, 0.95))):
        thing.location = location
        thing.rotation_euler = (
            (mathutils.Vector((-0.5, 2.0, 2.9)) - mathutils.Vector(location))
            .to_track_quat("-Z", "Y")
            .to_euler()
        )
        thing.keyframe_insert("location", frame=frame)
        thing.keyframe_insert("rotation_euler", frame=frame)
    scene.camera = thing


def main(output):
    """Builds the scene and exports it."""
    rng = random.Random("glade")
    scene = start()
    soil, bark = material("soil", "soil.png"), material("bark", "bark_oak.png")
    yellow, amber, red = (
        material(f"{age} maple", f"maple_{age}.png", 0.6, 0.8) for age in ("yellow", "amber", "red")
    )
    brown = material("brown maple", "maple_brown.png", 0.15, 0.5)
    solid = [
        place(f"ground {name}", mesh(f"ground_{name}", soil))
        for name in ("clearing", "left", "right", "beyond")
    ]
    drift = material("drift", "drift.png")
    for name in ("drifts", "drifts_beyond"):
        place(name, mesh(name, drift))
    twig = bpy.data.materials.new("twig")
    twig.use_nodes = True
    dry = twig.node_tree.nodes["Principled BSDF"].inputs
    dry["Base Color"].default_value = (0.06, 0.045, 0.035, 1.0)
    dry["Specular IOR Level"].default_value, dry["Roughness"].default_value = 0.0, 1.0
    wood, twigs = mesh("oak_wood", bark), mesh("oak_twigs", twig)
    oak = mathutils.Matrix.Translation((-2.6, 2.6, 0.0)) @ mathutils.Matrix.Rotation(0.9, 4, "Z")
    trunk, fine = place("oak", wood), place("oak twigs", twigs)
    trunk.matrix_world = fine.matrix_world = oak
    hanging = [mesh("maple_canopy_hanging", shade) for shade in (amber, yellow, red)]
    crown("crown", Twigs(twigs, oak), 10000, (hanging, (0.18, 0.30)), rng)
    # Nearer than the light, so dark: what frames the picture.
    frame = mathutils.Matrix.Translation((5.0, -0.9, -0.3)) @ mathutils.Matrix.Rotation(2.6, 4, "Z")
    place("oak 2", wood).matrix_world = place("oak 2 twigs", twigs).matrix_world = frame
    dark = [mesh("maple_canopy_hanging", brown)]
    crown("crown 2", Twigs(twigs, frame), 2500, (dark, (0.18, 0.30)), rng)
    maple_bark = material("maple bark", "bark_maple.png")
    beyond(maple_bark, twig, hanging, rng)
    leaves = [mesh("maple_far", shade) for shade in (brown, amber, brown, yellow)]
    for number in range(1500):
        x, y = rng.uniform(-7, 7), rng.uniform(-7, 8)
        turn = (rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), rng.uniform(0, math.tau))
        place(f"litter {number}", leaves[number % 4], (x, y, 0.05), turn, rng.uniform(0.08, 0.20))
    falling(fine, [*solid, trunk], (yellow, amber), rng)
    light_and_fog(scene)
    camera(scene)
    output.parent.mkdir(parents=True, exist_ok=True)
    return command.main(["export", str(output)])


if __name__ == "__main__":
    default = ROOT / "scenes" / "blender_glade" / "glade.glb"
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else default))
