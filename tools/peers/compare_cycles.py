#!/usr/bin/env python3
"""The same scenes, made in Blender, in Cycles and by sunfleck from the exported file: a table of mean ratios.

    python3.11 -m venv .venv && .venv/bin/pip install '.[cycles]'
    .venv/bin/python tools/peers/compare_cycles.py --sunfleck target/release/sunfleck

Cycles with all bounces 0 is direct light and single scattering, which is what sunfleck computes. Exits with 1
if a mean differs by more than the bar.
"""

import math
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "blender"), str(HERE.parent / "blender" / "tests")]

import bpy
import numpy

import scenes
from beside_stage import lamp, stage
import sunfleck
from sunfleck_tools.peers import beside
from common import parser

SIZE = (160, 90)


def fog(scene, density=0.15):
    """Cube of fog, in Cycles by its material and in sunfleck by its setting."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new("fog")
    mesh.from_pydata(corners, [], quads)
    shade = bpy.data.materials.new("fog")
    shade.use_nodes = True
    nodes = shade.node_tree.nodes
    nodes.clear()
    scatter, out = nodes.new("ShaderNodeVolumeScatter"), nodes.new("ShaderNodeOutputMaterial")
    scatter.inputs["Density"].default_value, scatter.inputs["Anisotropy"].default_value = density, 0.4
    scatter.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    shade.node_tree.links.new(scatter.outputs[0], out.inputs["Volume"])
    mesh.materials.append(shade)
    box = scenes.add(scene, "fog", mesh, (0.0, 0.5, 1.3))
    box.scale = (3.0, 2.2, 1.25)
    own = box.sunfleck_settings
    own.is_fog, own.density, own.anisotropy = True, density, 0.4
    return box


def shifted(scene):
    scene.camera.data.shift_x, scene.camera.data.shift_y = 0.12, -0.08
    scenes.sun(scene)


def rectangle(scene):
    lamp(scene, "AREA", energy=60.0, shape="RECTANGLE", size=0.8, size_y=0.4)


def noisy(scene):
    """Floor with nodes that are baked."""
    tree = bpy.data.materials["floor"].node_tree
    noise, ramp = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeValToRGB")
    noise.inputs["Scale"].default_value = 3.0
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (
        (0.8, 0.3, 0.05, 1.0),
        (0.1, 0.4, 0.1, 1.0),
    )
    tree.links.new(noise.outputs["Fac"], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    scenes.sun(scene)


def lit_from_behind(scene):
    """Wall of Diffuse and Translucent BSDF, mixed by a constant, in front of a sun."""
    tree = bpy.data.materials["wall"].node_tree
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.inputs[0].default_value = 0.4
    for number, kind, color in (
        (1, "Diffuse", (0.2, 0.5, 0.1, 1.0)),
        (2, "Translucent", (0.6, 0.8, 0.2, 1.0)),
    ):
        shader = tree.nodes.new(f"ShaderNodeBsdf{kind}")
        shader.inputs["Color"].default_value = color
        tree.links.new(shader.outputs[0], mix.inputs[number])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    scenes.sun(scene, towards=(0.2, -0.8, -0.6))


def scattered(scene):
    """Leaves from geometry nodes, each with a random colour."""
    leaf = scenes.quad(scene, "leaf", 0.25, scenes.material("leaf", (0.5, 0.5, 0.1)))
    leaf.hide_render = True
    tree = leaf.data.materials[0].node_tree
    info, ramp = tree.nodes.new("ShaderNodeObjectInfo"), tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (
        (0.8, 0.1, 0.0, 1.0),
        (0.1, 0.6, 0.1, 1.0),
    )
    tree.links.new(info.outputs["Random"], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    emitter = scenes.quad(scene, "emitter", 4.0, scenes.material("emitter", (0.5, 0.5, 0.5)), (0.0, 0.0, 1.2))
    settings = emitter.modifiers.new("fall", "PARTICLE_SYSTEM").particle_system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 60, 0, 0, 50
    settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", leaf, 1.0
    settings.normal_factor, settings.effector_weights.gravity = 0.0, 0.0
    emitter.show_instancer_for_render = False
    scenes.sun(scene)


SCENES = {
    "sun": scenes.sun,
    "sun, a disc of 10 deg": lambda scene: scenes.sun(scene, angle=math.radians(10.0)),
    "sun, shifted lens": shifted,
    "point": lambda scene: lamp(scene, "POINT", energy=100.0, shadow_soft_size=0.0),
    # With soft falloff Cycles uses a disc that faces each lit point.
    "sphere": lambda scene: lamp(scene, "POINT", energy=100.0, shadow_soft_size=0.2, use_soft_falloff=False),
    "spot": lambda scene: lamp(
        scene, "SPOT", energy=300.0, shadow_soft_size=0.0, spot_size=math.radians(70.0), spot_blend=0.4
    ),
    "area, rectangle": rectangle,
    "area, disk": lambda scene: lamp(scene, "AREA", energy=60.0, shape="DISK", size=0.6),
    "material, baked": noisy,
    "material, lit from behind": lit_from_behind,
    "particles, random colours": scattered,
    "sun in fog": lambda scene: (scenes.sun(scene), fog(scene)),
    "point in fog": lambda scene: (lamp(scene, "POINT", energy=100.0, shadow_soft_size=0.0), fog(scene)),
    "spot in fog": lambda scene: (
        lamp(scene, "SPOT", energy=300.0, shadow_soft_size=0.0, spot_size=math.radians(70.0), spot_blend=0.4), fog(scene)
    ),
    "area in fog": lambda scene: (rectangle(scene), fog(scene)),
}


def compare(name, build, arguments, folder):
    """Mean ratio, and the root mean square difference relative to the mean."""
    scene = stage()
    build(scene)
    wish = beside.Wish(arguments.sunfleck, 1, SIZE, arguments.samples, arguments.cycles_samples)
    ours, theirs, _ = beside.pictures(scene, wish, folder)
    ratio = ours.mean() / theirs.mean()
    difference = float(numpy.sqrt(numpy.mean((ours - theirs) ** 2)) / theirs.mean())
    print(f"{name:24} {theirs.mean():10.5f} {ratio:9.5f} {100.0 * difference:9.2f} %", flush=True)
    return ratio


def main():
    command = parser(__doc__)
    command.add_argument("--sunfleck", type=Path, default=Path("target/release/sunfleck"))
    command.add_argument("--samples", type=int, default=64, help="of sunfleck")
    command.add_argument("--cycles-samples", type=int, default=256)
    command.add_argument("--bar", type=float, default=0.005, help="largest difference of a mean ratio from 1")
    command.add_argument("--only", help="scenes whose name holds this")
    arguments = command.parse_args()
    scenes.empty()
    sunfleck.register()
    wanted = {name: build for name, build in SCENES.items() if (arguments.only or "") in name}
    print(f"{'scene':24} {'mean':>10} {'ratio':>9} {'difference':>11}")
    with tempfile.TemporaryDirectory() as folder:
        ratios = [compare(name, build, arguments, Path(folder)) for name, build in wanted.items()]
    return int(any(abs(ratio - 1.0) > arguments.bar for ratio in ratios))


if __name__ == "__main__":
    sys.exit(main())
