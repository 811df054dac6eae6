"""Preparation of Blender's graphs before a rendering.

A render graph reads caches of simulations without stepping them, so they are filled here. Materials and
worlds have the animated values of the viewport's graph at its last frame. Creating a datablock rebuilds all
graphs, so queries that need one are made here.

Invariant: before a frame is rendered, the viewport's graph has evaluated it. With simulations it has also
evaluated all earlier frames, and later ones that the shutter or a motion pass reaches. Visibility is
restored afterwards.
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

# Running renderings, by the names of their scenes.
_running = {}


class Running:
    """Undo of changed visibility, and the last frame that was stepped."""

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
    """Last evaluated frame; for a single rendered frame it is the current one."""

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
    """Steps to the next frame to render."""
    running = _running.get(scene.name)
    if running is not None:
        running.step(scene, scene.frame_current)


def frames_ahead(scene):
    """Number of later frames that a frame's shutter and motion pass reach."""
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
