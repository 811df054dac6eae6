"""Makes scenes/blender_glade/glade.glb in Blender: a clearing with one oak, its leaves in the wind.

    PYTHONPATH=tools/blender python tools/blender/examples/glade.py [GLB]

needs `pip install bpy`, and the meshes and textures of scenes/woods. Everything after the imports is what an
artist does with the mouse: place meshes, key objects, set the add-on's properties, export. The same
versions of Blender and of this file write the same scene.
"""

import math
import random
import sys
from pathlib import Path

import bpy
import mathutils

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


def place(scene, name, data, location=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0), size=1.0):
    """An object that shows a mesh."""
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    thing.location, thing.rotation_euler, thing.scale = location, turn, (size, size, size)
    return thing


def crown(scene, name, leaves, twigs, world_from_twigs, count, sizes, rng):
    """Leaves that hang from twigs' vertices; all share a few meshes."""
    for number in range(count):
        leaf = place(scene, f"{name} {number}", rng.choice(leaves), size=rng.uniform(*sizes))
        leaf.location = world_from_twigs @ rng.choice(twigs.vertices).co
        droop, roll = math.radians(rng.uniform(-10, 80)), math.radians(rng.uniform(-50, 50))
        leaf.rotation_euler = (-droop, roll, rng.uniform(0, math.tau))


def fall(scene, leaf, number, rng):
    """A leaf that is blown across the clearing, keyed four times a second."""
    thing = place(scene, f"leaf {number}", leaf, size=rng.uniform(0.14, 0.24))
    x, y, z = rng.uniform(-6, 3), rng.uniform(-4, 7), rng.uniform(0.4, 6.5)
    phase, swing, speed = rng.uniform(0, math.tau), rng.uniform(0.1, 0.35), rng.uniform(0.5, 1.0)
    spin = mathutils.Vector((rng.uniform(-2.5, 2.5), rng.uniform(-2.5, 2.5), rng.uniform(-2.0, 2.0)))
    turn = mathutils.Vector(rng.uniform(0, math.tau) for _ in range(3))
    for frame in range(FRAMES[0], FRAMES[1] + 6, 6):
        t = frame / 24.0
        gust = 0.6 * t + 0.25 * math.sin(1.7 * t + 0.3 * x)
        thing.location = (
            x + gust + swing * math.sin(4.0 * t + phase),
            y + swing * math.cos(3.1 * t + phase),
            max(z - speed * t, 0.03),
        )
        thing.rotation_euler = turn + spin * t
        thing.keyframe_insert("location", frame=frame)
        thing.keyframe_insert("rotation_euler", frame=frame)


def light_and_fog(scene):
    """A low sun from the side, morning fog that thins out, a dim sky behind."""
    data = bpy.data.lights.new("sun", "SUN")
    data.energy, data.color, data.angle = 11.0, (1.0, 0.62, 0.28), math.radians(1.2)
    sun = place(scene, "sun", data)
    sun.rotation_euler = mathutils.Vector((0.30, -0.80, -0.36)).to_track_quat("-Z", "Y").to_euler()
    settings = scene.sunfleck_settings
    fog = place(scene, "fog", None, (0.0, 20.0, 10.0))
    fog.scale = (24.0, 32.0, 13.0)
    holds = fog.sunfleck_settings
    holds.is_fog, holds.density, holds.albedo, holds.anisotropy = True, 0.0075, (0.96, 0.92, 0.84), 0.8
    settings.background_color, settings.background_strength = (0.62, 0.62, 0.60), 0.10
    settings.tolerance, settings.passes = 0.04, set()


def camera(scene):
    """Close to the ground, moving in slowly; the oak is in focus."""
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.lens = "HORIZONTAL", 26.0
    data.dof.use_dof, data.dof.focus_distance, data.dof.aperture_fstop = True, 9.0, 1.4
    thing = place(scene, "camera", data)
    for frame, location in ((FRAMES[0], (0.6, -7.6, 0.85)), (FRAMES[1], (0.2, -6.9, 0.95))):
        thing.location = location
        thing.rotation_euler = (mathutils.Vector((-0.5, 2.0, 2.9)) - mathutils.Vector(location)).to_track_quat("-Z", "Y").to_euler()
        thing.keyframe_insert("location", frame=frame)
        thing.keyframe_insert("rotation_euler", frame=frame)
    scene.camera = thing


def main(output):
    """Builds the scene and exports it."""
    rng = random.Random("glade")
    scene = start()
    litter, bark = material("litter", "litter.png", factor=0.5), material("bark", "bark_oak.png")
    yellow, amber = material("yellow maple", "maple_yellow.png", 0.6), material("amber maple", "maple_amber.png", 0.6)
    for name in ("clearing", "left", "right", "beyond"):
        place(scene, f"ground {name}", mesh(f"ground_{name}", litter))
    twig = bpy.data.materials.new("twig")
    twig.use_nodes = True
    twig.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.06, 0.045, 0.035, 1.0)
    wood, twigs = mesh("oak_wood", bark), mesh("oak_twigs", twig)
    oak = mathutils.Matrix.Translation((-2.6, 2.6, 0.0)) @ mathutils.Matrix.Rotation(0.9, 4, "Z")
    for name, data in (("oak", wood), ("oak twigs", twigs)):
        place(scene, name, data).matrix_world = oak
    hanging = [mesh("maple_canopy_hanging", shade) for shade in (amber, yellow)]
    crown(scene, "crown", hanging, twigs, oak, 2200, (0.18, 0.30), rng)
    maple_bark = material("maple bark", "bark_maple.png")
    far_wood = mesh("birch_wood", maple_bark)
    for i, (x, y) in enumerate([(7.5, 16.0), (-9.0, 19.0), (3.4, 24.0), (13.0, 27.0), (-3.0, 31.0), (-15.0, 28.0)]):
        place(scene, f"far tree {i + 1}", far_wood, (x, y, 0.0), (0.0, 0.0, rng.uniform(0, math.tau)), rng.uniform(1.2, 1.5))
    leaves = [mesh("maple_far", yellow), mesh("maple_far", amber)]
    near = mesh("maple_near", yellow)
    for number in range(150):
        fall(scene, leaves[number % 2], number, rng)
    for number in range(150, 158):
        fall(scene, near, number, rng)
    for number in range(420):
        x, y = rng.uniform(-7, 7), rng.uniform(-7, 8)
        turn = (rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4), rng.uniform(0, math.tau))
        place(scene, f"litter {number}", leaves[number % 2], (x, y, 0.03), turn, rng.uniform(0.14, 0.24))
    light_and_fog(scene)
    camera(scene)
    output.parent.mkdir(parents=True, exist_ok=True)
    return command.main(["export", str(output)])


if __name__ == "__main__":
    default = ROOT / "scenes" / "blender_glade" / "glade.glb"
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else default))
