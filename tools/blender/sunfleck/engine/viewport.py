"""Pictures for a viewport: first at reduced size, then at full size, of a scene that stays loaded.

In go a viewport's graph and view, out comes the last finished picture. Invariant: no call blocks; a change
cancels the current picture. This module draws nothing.
"""

import copy
import math

import numpy

from .. import extras, program, service
from ..evaluated import scenes
from ..stored import by_hand
from . import picture
from . import patching
from .exporting import Kept, folder, told

# Share of the size, and samples, of successive pictures until the view changes.
STAGES = ((0.25, 1), (0.5, 1), (1.0, 1), (1.0, 4), (1.0, 16))
NAME = "viewport"


class View:
    """View of a region: 4x4 matrices of view and projection, as in Blender."""

    def __init__(self, size, view_matrix, window_matrix, is_perspective):
        self.size, self.is_perspective = size, is_perspective
        self.from_world, self.projection = numpy.array(view_matrix, float), numpy.array(window_matrix, float)

    @classmethod
    def of(cls, context):
        region, data = context.region, context.region_data
        return cls((region.width, region.height), data.view_matrix, data.window_matrix, data.is_perspective)

    def __eq__(self, other):
        return isinstance(other, View) and self.told() == other.told()

    def told(self):
        return self.size, self.is_perspective, self.from_world.tolist(), self.projection.tolist()

    def camera(self):
        """Camera for the program."""
        return service.viewer(numpy.linalg.inv(self.from_world), self.lens())

    def lens(self):
        """Lens of a glTF camera."""
        near, aspect, across = 1e-3, self.size[0] / self.size[1], 1.0 / self.projection[1, 1]
        if not self.is_perspective:
            lens = {"xmag": across * aspect, "ymag": across, "znear": near, "zfar": 1e6}
            said = {"type": "orthographic", "orthographic": lens}
        else:
            lens = {"yfov": 2.0 * math.atan(across), "aspectRatio": aspect, "znear": near}
            said = {"type": "perspective", "perspective": lens}
        # Offset of the picture's centre from the view axis, in halves of its sides.
        beside = self.projection[:2, 2] if self.is_perspective else -self.projection[:2, 3]
        shift = [0.5 * beside[axis] * self.size[axis] / max(self.size) for axis in (0, 1)]
        return {**said, "extras": {"sunfleck_camera": {"shift": shift}}} if any(shift) else said


class Viewport:
    """State of one region; `poll` is called whenever it is drawn."""

    def __init__(self):
        self.kept = self.view = self.service = self.run = self.shown = None
        self.stage, self.number, self.problem = 0, 0, ""

    def changed(self, graph):
        """Writes the file again; meshes are exported again unless objects have only moved and lights
        changed."""
        self.close()
        self.view, kept = None, self.kept
        if kept is not None and told(graph.scene, graph.view_layer) == kept.told and patching.put(graph, kept):
            kept.exported.assembly.document.write(self.path)
        else:
            self.kept = self.anew(graph, graph.scene)

    def anew(self, graph, scene):
        self.path = folder() / f"{NAME}_{id(self)}.glb"
        with scenes.Job(scene, scene.frame_current) as job:
            job.visit(graph, scene.frame_current, 0.0)
            said = {**by_hand(scene), **extras.of_scene(scene, self.path)}
            made = job.written(self.path, graph.view_layer, copy.deepcopy(said))
        return Kept(self.path, graph, made, [], said)

    def look(self, view):
        """Starts again if the view has changed."""
        if self.kept is None or view == self.view:
            return
        self.cancel()
        self.view, self.stage = view, 0
        self.start()

    def start(self):
        executable = program.find()
        if executable is None:
            self.problem = program.MISSING
            return
        is_new = self.service is None or not self.service.is_alive()
        if is_new:
            self.service = service.Service(executable, self.path)
        share, samples = STAGES[self.stage]
        width, height = (max(1, round(share * side)) for side in self.view.size)
        flags = [f"--size={width}x{height}", f"--samples={samples}", "--passes=none"]
        flags.append(f"--frames={self.kept.frame}")
        flags.append(f"--out={self.path.with_suffix('.exr')}")
        # A change shows before its indirect light is solved.
        flags += ["--bounces=0"] if is_new and self.stage == 0 else []
        self.run = self.service.render(flags, self.view.camera())

    def poll(self):
        """Whether more pictures will come."""
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
        self.close()

    def cancel(self):
        if self.run is not None:
            self.run.cancel()
            self.run = None

    def close(self):
        self.cancel()
        if self.service is not None:
            self.service.close()
            self.service = None
