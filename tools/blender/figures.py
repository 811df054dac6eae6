"""Figures of the render engine, printed: how much longer F12 takes than the program alone, when the first pixel
shows, how fast Esc is heard, what 50 renders leave in memory.

    SUNFLECK=target/release/sunfleck python tools/blender/figures.py [f12 second pixel esc memory pixels viewport]

In go names of figures, all without; out comes a line for each, by the Blender that runs this. Invariant: it is the
engine as Blender calls it, without a window. Processor seconds tell more than the clock where others are at work.
"""

import contextlib
import math
import os
import random
import resource
import statistics
import sys
import tempfile
import time
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).parent))

import bpy
import numpy
import sunfleck
from sunfleck import engine, render
from sunfleck.engine import exporting, picture
from sunfleck.engine.viewport import View, Viewport

ROUNDS = 3
FOLDER = Path(tempfile.mkdtemp(prefix="sunfleck_figures_"))


class Clock:
    """Seconds by the clock, and by the processors, of Blender and of programs that have ended."""

    def __enter__(self):
        self.wall, self.cpu = time.perf_counter(), processor_s()
        return self

    def __exit__(self, *_):
        self.wall, self.cpu = time.perf_counter() - self.wall, processor_s() - self.cpu

    def __str__(self):
        return f"{self.wall:.2f} s ({self.cpu:.2f} CPU s)"


def processor_s():
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def default_scene(percent=100):
    """As Blender opens, 1920 x 1080 pixels, but for the engine."""
    bpy.ops.wm.read_factory_settings(use_empty=False)
    if not hasattr(bpy.types.Scene, "sunfleck_settings"):
        sunfleck.register()
    scene = bpy.context.scene
    scene.render.engine, scene.render.filepath = "SUNFLECK", str(FOLDER / "blender")
    scene.render.resolution_percentage = percent
    return scene


def with_leaves(scene, count=2000):
    mesh, chance = bpy.data.meshes.new("leaf"), random.Random(1)
    mesh.from_pydata([(-0.1, 0, 0), (0, -0.2, 0.02), (0.1, 0, 0), (0, 0.2, 0.02)], [], [(0, 1, 2), (0, 2, 3)])
    mesh.materials.append(scene.objects["Cube"].data.materials[0])
    for number in range(count):
        leaf = bpy.data.objects.new(f"leaf {number}", mesh)
        scene.collection.objects.link(leaf)
        leaf.location = [chance.uniform(low, high) for low, high in ((-3, 3), (-3, 3), (0, 3))]
        leaf.rotation_euler = [chance.uniform(0, 2 * math.pi) for _ in range(3)]
    return scene


def f12():
    """Blender's F12, and the program on the same file with the same flags, in turns."""
    default_scene()
    ratios = []
    for _ in range(ROUNDS):
        with mock.patch.object(render, "Run", side_effect=render.Run) as run, Clock() as whole:
            bpy.ops.render.render()
        executable, path, frame, flags = run.call_args.args
        with Clock() as alone:
            render.Run(executable, path, frame, [flag for flag in flags if not flag.startswith("--live")]).wait()
        ratios.append(whole.cpu / alone.cpu)
        yield f"F12 {whole}, the program alone {alone}: {whole.wall / alone.wall:.3f}, of processors {ratios[-1]:.3f}"
    yield f"median {statistics.median(ratios):.3f} of processors (bar 1.1)"


def second():
    """A turned camera with *Persistent Data*: what comes before the program is asked, and after it has ended."""
    scene = default_scene()
    scene.render.use_persistent_data = True
    bpy.ops.render.render()
    for _ in range(ROUNDS):
        scene.camera.rotation_euler.z += 0.02
        times = [time.perf_counter()]
        with contextlib.ExitStack() as stack:
            for module, name in ((exporting, "started"), (picture, "hand_over")):
                stack.enter_context(mock.patch.object(module, name, side_effect=noting(times, getattr(module, name))))
            anew = stack.enter_context(mock.patch.object(exporting, "anew", side_effect=exporting.anew))
            bpy.ops.render.render()
        start, asked, ended, end = *times, time.perf_counter()
        ratio = (end - start) / (ended - asked)
        yield f"second F12 {end - start:.2f} s, {ratio:.3f} of the program's time (bar 1.02); exports anew: {anew.call_count}"


def noting(times, function):
    def noted(*arguments):
        times.append(time.perf_counter())
        return function(*arguments)

    return noted


def pixel():
    for _ in range(ROUNDS):
        with_leaves(default_scene())
        seen = []
        with mock.patch.object(picture, "show", side_effect=noting(seen, picture.show)):
            # Enough is seen.
            with mock.patch.object(engine.SUNFLECK_RENDER_engine, "is_stopped", lambda _: bool(seen)):
                used, start = processor_s(), time.perf_counter()
                bpy.ops.render.render()
        yield f"2,000 leaves: first pixel after {seen[0] - start:.2f} s (bar 1.5), {processor_s() - used:.2f} CPU s until stopped"


def esc():
    """At 100 random moments while the engine is at work: Blender asks nobody before and after."""
    with_leaves(default_scene(percent=25))
    kind, late, chance = engine.SUNFLECK_RENDER_engine, [], random.Random(2)
    rendered = kind.rendered
    for _ in range(100):
        at = []

        def begins(self, graph):
            at.append(time.perf_counter() + chance.uniform(0.0, 1.5))
            try:
                rendered(self, graph)
            finally:
                late.append(1e3 * (time.perf_counter() - at[0]))

        with mock.patch.multiple(kind, rendered=begins, is_stopped=lambda _: time.perf_counter() > at[0]):
            bpy.ops.render.render()
    heard = sorted(one for one in late if one > 0.0)
    soon = sum(one <= 100.0 for one in heard)
    yield f"Esc: {soon} of {len(heard)} heard within 100 ms, half of them within {statistics.median(heard):.0f}, all within {heard[-1]:.0f}"


def memory():
    default_scene(percent=10)
    found = []
    for _ in range(50):
        bpy.ops.render.render()
        found.append(int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6)
    yield f"50 renders: {found[2]:.0f} MB after 3, {found[24]:.0f} after 25, {found[-1]:.0f} after 50"


def pixels():
    scene = default_scene(percent=25)
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    with mock.patch.object(exporting, "started", side_effect=exporting.started) as started:
        bpy.ops.render.render(write_still=True)
    ours = picture.read(started.call_args.args[2].path.with_suffix(".exr"))
    theirs = picture.read(FOLDER / "blender.exr")
    yield f"pixels equal: {all(numpy.array_equal(ours.of((one,)), theirs.of((one,))) for one in 'RGB')}"


def viewport():
    """Of a region of 960x540 pixels: from a change to the first picture, and to the last."""
    for name, more in (("default scene", lambda scene: scene), ("2,000 leaves in fog", lambda scene: in_fog(with_leaves(scene)))):
        scene = more(default_scene())
        shown, lamp, cube = Viewport(), scene.objects["Light"], scene.objects["Cube"]
        roughness = cube.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Roughness"]
        changes = {
            "nothing shown yet": lambda: shown.changed(bpy.context.evaluated_depsgraph_get()),
            "turned view": lambda: scene.camera.rotation_euler.rotate_axis("Z", 0.02),
            "moved lamp": lambda: setattr(lamp.location, "z", lamp.location.z + 0.5),
            "moved object": lambda: setattr(cube.location, "x", cube.location.x + 0.2),
            "changed material": lambda: setattr(roughness, "default_value", 0.3),
        }
        for change, make in changes.items():
            with Clock() as last:
                first = shows(shown, scene, make, is_told=change.startswith(("moved", "changed")))
            yield f"viewport, {name}, {change}: first picture after {first:.2f} s, last {last.wall:.2f} s"
        shown.close()


def in_fog(scene):
    fog = bpy.data.objects.new("fog", None)
    scene.collection.objects.link(fog)
    fog.scale, fog.sunfleck_settings.is_fog, fog.sunfleck_settings.density = (6.0,) * 3, True, 0.05
    return scene


def shows(shown, scene, make, is_told):
    """Seconds until a viewport shows a change, of which Blender tells it or not; then its last picture is awaited."""
    tell, start = lambda _, graph: shown.changed(graph), time.perf_counter()
    handlers = bpy.app.handlers.depsgraph_update_post
    handlers.extend([tell] if is_told else [])
    make()
    bpy.context.view_layer.update()
    if is_told:
        handlers.remove(tell)
    graph, camera, times = bpy.context.evaluated_depsgraph_get(), scene.camera, []
    window = camera.calc_matrix_camera(graph, x=960, y=540)
    shown.look(View((960, 540), camera.matrix_world.inverted(), window, True))
    number = shown.number
    while shown.poll():
        if shown.number > number and not times:
            times.append(time.perf_counter() - start)
        time.sleep(0.005)
    return times[0]


FIGURES = {made.__name__: made for made in (f12, second, pixel, esc, memory, pixels, viewport)}

if __name__ == "__main__":
    print(f"Blender {bpy.app.version_string}, load {os.getloadavg()[0]:.1f}")
    for name in sys.argv[1:] or FIGURES:
        for line in FIGURES[name]():
            print(line, flush=True)
