"""What has to happen before Blender renders.

A graph that renders reads caches of simulations and steps nothing, so they are filled here. It gives its values to
no material or world: those have what the viewport's graph was last shown. To make anything has Blender build all
graphs anew, so what is asked in that way is asked here.

Invariant: when a frame is rendered, the viewport's graph has been shown it; if anything is simulated, also all
before it and those after it that the shutter or a motion pass reaches. What was hidden is hidden again afterwards.
"""

import math
from contextlib import ExitStack

import bpy
from bpy.app.handlers import persistent

from .. import keys
from ..evaluated import simulations, walk
from ..evaluated.moments import Shutter
from ..film import ENGINE
from ..materials import blackbody, colours, inputs
from . import passes

# By the names of scenes that render.
_running = {}


class Running:
    """How to undo what was made visible, and the last frame that was stepped."""

    def __init__(self, scene):
        self.stack, self.last = ExitStack(), scene.frame_start - 1
        self.stack.enter_context(simulations.run(scene, walk.view_layer(scene), ()))

    def step(self, scene, frame):
        until = frame + frames_ahead(scene)
        for number in range(self.last + 1, until + 1):
            scene.frame_set(number)
        self.last = max(self.last, until)
        if scene.frame_current != frame:
            scene.frame_set(frame)


class Shown:
    """The last frame that was shown, which of a frame rendered alone is the one at hand."""

    def __init__(self, scene):
        self.stack, self.last = ExitStack(), scene.frame_current

    def step(self, scene, frame):
        if frame != self.last:
            scene.frame_set(frame)
            self.last = frame


@persistent
def begin(scene, *_):
    finish(scene)
    if scene.render.engine != ENGINE:
        return
    blackbody.table(colours.working_space())
    inputs.know([*bpy.data.materials, *bpy.data.worlds, *bpy.data.lights], bpy.data.node_groups)
    if simulations.any_in(scene):
        _running[scene.name] = Running(scene)
    elif any(map(keys.changes, [*bpy.data.materials, *bpy.data.worlds])):
        _running[scene.name] = Shown(scene)


@persistent
def step(scene, *_):
    """To the frame that is rendered next."""
    running = _running.get(scene.name)
    if running is not None:
        running.step(scene, scene.frame_current)


def frames_ahead(scene):
    """How far behind a frame its shutter and its motion pass look."""
    shutter = Shutter.of(scene)
    is_moving = any("motion" in passes.wanted(scene, layer) for layer in scene.view_layers if layer.use)
    return max(int(is_moving), math.ceil(shutter.opening + shutter.length))


@persistent
def finish(scene, *_):
    running = _running.pop(scene.name, None)
    if running is not None:
        running.stack.close()


HANDLERS = {"render_init": begin, "render_pre": step, "render_complete": finish, "render_cancel": finish}


def register():
    for name, handler in HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in HANDLERS.items():
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
