"""Scenes made in Blender for the tests."""

import math

import bpy
import mathutils


def empty(frames=(1, 1), size=(64, 36)):
    """A scene without anything, of that many frames."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = frames
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    return scene


def add(scene, name, data, location=(0.0, 0.0, 0.0), towards=None):
    """An object; cameras and lights look towards a point."""
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    thing.location = location
    if towards is not None:
        direction = mathutils.Vector(towards) - mathutils.Vector(location)
        thing.rotation_euler = direction.to_track_quat("-Z", "Y").to_euler()
    return thing


def material(name, colour):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Specular IOR Level"].default_value = 0.0
    shader.inputs["Roughness"].default_value = 1.0
    return made


def quad(scene, name, size, shade, location=(0.0, 0.0, 0.0)):
    half = size / 2
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(
        [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [], [(0, 1, 2, 3)]
    )
    mesh.materials.append(shade)
    return add(scene, name, mesh, location)


def camera(scene, location=(0.0, -6.0, 2.0), towards=(0.0, 0.0, 0.6), angle_deg=45.0):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle_x = "HORIZONTAL", math.radians(angle_deg)
    data.clip_start, data.clip_end = 1e-4, 1e4
    scene.camera = add(scene, "camera", data, location, towards)
    return scene.camera


def sun(scene, strength=3.0, angle=0.0, towards=(0.3, 0.4, -1.0)):
    data = bpy.data.lights.new("sun", "SUN")
    data.energy, data.angle = strength, angle
    return add(scene, "sun", data, (0.0, 0.0, 5.0), (towards[0], towards[1], 5.0 + towards[2]))


def fog_box(scene, low=(-3.0, -3.0, 0.0), high=(3.0, 3.0, 3.0), density=0.1):
    """An empty that holds fog."""
    volume = add(scene, "fog", None, [0.5 * (a + b) for a, b in zip(low, high)])
    volume.scale = [0.5 * (b - a) for a, b in zip(low, high)]
    volume.sunfleck_settings.is_fog = True
    volume.sunfleck_settings.density = density
    return volume
