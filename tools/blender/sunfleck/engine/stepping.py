"""Caches of simulations, filled before Blender renders. A graph that renders reads them and steps nothing.

Invariant: when a frame is rendered, the viewport's graph has been shown it, and all before it. What was hidden
is hidden again afterwards.
"""

from contextlib import ExitStack

import bpy
from bpy.app.handlers import persistent

from ..evaluated import simulations, walk
from ..world import ENGINE

# By the names of scenes that render.
_running = {}


class Running:
    """How to undo what was made visible, and the last frame that was stepped."""

    def __init__(self, scene):
        self.stack, self.last = ExitStack(), scene.frame_start - 1
        self.stack.enter_context(simulations.run(scene, walk.view_layer(scene), ()))


@persistent
def begin(scene, *_):
    finish(scene)
    if scene.render.engine == ENGINE and simulations.any_in(scene):
        _running[scene.name] = Running(scene)


@persistent
def step(scene, *_):
    """To the frame that is rendered next."""
    running = _running.get(scene.name)
    if running is None:
        return
    frame = scene.frame_current
    if frame <= running.last:
        return
    for number in range(running.last + 1, frame + 1):
        scene.frame_set(number)
    running.last = frame


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
