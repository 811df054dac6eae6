"""Pictures for a viewport: a part of the size first, then all of it, each by a run of the program.

In go a graph that the viewport shows and how it is looked at, out come pictures, the last one finished at any
time. Invariant: nothing waits; what has changed ends the run under way. It draws nothing itself.
"""

import math

import numpy

from .. import extras, program, render
from ..evaluated import places, scenes
from ..materials.library import custom
from . import picture
from .exporting import folder

# Share of the size and samples of each picture, until the view changes.
STAGES = ((0.25, 1), (1.0, 2), (1.0, 16))
NAME = "viewport"


class View:
    """How a region looks at the scene: 4x4 matrices of the view and of its projection, as Blender has them."""

    def __init__(self, size, view_matrix, window_matrix, is_perspective):
        self.size, self.is_perspective = size, is_perspective
        self.from_world, self.projection = numpy.array(view_matrix, float), numpy.array(window_matrix, float)

    @classmethod
    def of(cls, context):
        region, data = context.region, context.region_data
        return cls((region.width, region.height), data.view_matrix, data.window_matrix, data.is_perspective)

    def __eq__(self, other):
        return (
            isinstance(other, View)
            and (self.size, self.is_perspective) == (other.size, other.is_perspective)
            and numpy.array_equal(self.from_world, other.from_world)
            and numpy.array_equal(self.projection, other.projection)
        )

    def node(self):
        """Its place, as a node of glTF has it."""
        parts = places.parts(places.in_gltf(numpy.linalg.inv(self.from_world)[None], looks=True))
        return {name: getattr(parts, name)[0].tolist() for name in ("translation", "rotation")}

    def camera(self):
        """Its lens, as a camera of glTF has it."""
        near, aspect, across = 1e-3, self.size[0] / self.size[1], 1.0 / self.projection[1, 1]
        if not self.is_perspective:
            lens = {"xmag": across * aspect, "ymag": across, "znear": near, "zfar": 1e6}
            return {"type": "orthographic", "orthographic": lens}
        lens = {"yfov": 2.0 * math.atan(across), "aspectRatio": aspect, "znear": near}
        said = {"type": "perspective", "perspective": lens}
        # Where the middle of the picture lies beside the way that the camera looks, in halves of its sides.
        shift = [0.5 * self.projection[axis, 2] * self.size[axis] / max(self.size) for axis in (0, 1)]
        return {**said, "extras": {"sunfleck_camera": {"shift": shift}}} if any(shift) else said


class Viewport:
    """What one region shows; `poll` is called whenever it is drawn."""

    def __init__(self):
        self.exported = self.view = self.eye = self.run = self.shown = None
        self.stage, self.number, self.problem = 0, 0, ""

    def changed(self, graph):
        """Everything may be another: the file is written anew."""
        self.cancel()
        scene = graph.scene
        self.path = folder() / f"{NAME}_{id(self)}.glb"
        with scenes.Job(scene, scene.frame_current) as job:
            job.visit(graph, scene.frame_current, 0.0)
            said = {**custom(scene), **extras.of_scene(scene, self.path)}
            self.exported = job.written(self.path, graph.view_layer, said)
        # Of this file, so that there is one camera more.
        document = self.exported.assembly.document
        self.eye = document.add("nodes", {"name": NAME}), document.add("cameras", {})
        self.view = None

    def look(self, view):
        """Starts again where the view is another."""
        if self.exported is None or view == self.view:
            return
        self.cancel()
        self.view, self.stage = view, 0
        document = self.exported.assembly.document
        node, camera = self.eye
        document.lists["cameras"][camera] = view.camera()
        document.lists["nodes"][node] = {"name": NAME, "camera": camera, **view.node()}
        document.scene_extras["sunfleck"] = {**document.scene_extras["sunfleck"], "camera": NAME}
        document.write(self.path)
        self.start()

    def start(self):
        executable = program.find()
        if executable is None:
            self.problem = program.MISSING
            return
        share, samples = STAGES[self.stage]
        width, height = (max(1, round(share * side)) for side in self.view.size)
        flags = [f"--size={width}x{height}", f"--samples={samples}", "--passes=none"]
        flags.append(f"--frames={self.exported.frames[0]}")
        self.run = render.Run(executable, self.path, self.path.with_suffix(".exr"), flags)

    def poll(self):
        """Whether there is more to come."""
        if self.run is None or not self.run.is_over():
            return self.run is not None
        code, self.problem = self.run.wait(), self.run.error()
        self.run = None
        if code:
            return False
        self.shown, self.number = picture.read(self.path.with_suffix(".exr")), self.number + 1
        self.stage += 1
        if self.stage < len(STAGES):
            self.start()
        return self.run is not None

    def __del__(self):
        self.cancel()

    def cancel(self):
        if self.run is not None:
            self.run.cancel()
            self.run = None
