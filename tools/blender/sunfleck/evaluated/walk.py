"""Walk of the render's dependency graph, at every moment of every frame.

Blender gives only render engines a render graph (and not the viewport's), so this engine visits it and
renders nothing. In go a scene and a visitor, which is called with the graph at each moment. Invariant: the
scene is restored afterwards.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Protocol

import bpy

from . import simulations
from .moments import Shutter, steps_of

# Render settings that interfere with the visit.
ASIDE = {"engine": "SUNFLECK_WALK", "use_compositing": False, "use_sequencer": False, "use_multiview": False}


# Property of the camera without which Blender does not render.
STAND_IN = "sunfleck_stand_in"


class Stopped(Exception):
    """Blender was stopped before the last frame."""


class Job(Protocol):
    """Visitor."""

    def visit(self, graph: bpy.types.Depsgraph, frame: int, moment: float) -> None:
        """Visits the graph at a moment relative to a frame."""


def look(
    engine: bpy.types.RenderEngine, graph: bpy.types.Depsgraph, frames: Sequence[int], shutter: Shutter, job: Job
) -> Iterator[int]:
    """Calls `job.visit(graph, frame, moment)` from within an engine. The frame itself comes first, in
    order, as simulations require. Further moments of an open shutter follow."""
    scene = graph.scene
    moments = shutter.moments(max(map(steps_of, bpy.data.objects), default=1))
    is_simulated = simulations.any_in(scene)
    for frame in frames:
        for moment in moments:
            # Simulations have no state before the first frame.
            if is_simulated and frame + moment < scene.frame_start:
                continue
            whole = math.floor(frame + moment)
            engine.frame_set(whole, frame + moment - whole)
            job.visit(graph, frame, moment)
        yield frame


def walk(scene: bpy.types.Scene, frames: Sequence[int], shutter: Shutter, job: Job) -> None:
    """The same with an engine of its own."""
    layer = view_layer(scene)
    if not layer.use:
        raise Stopped("no view layer renders: tick Use for Rendering in the properties of one")
    is_simulated = simulations.any_in(scene)
    failed: list[Exception] = []
    seen: set[int] = set()

    class SUNFLECK_RENDER_walk(bpy.types.RenderEngine):
        bl_idname, bl_label, bl_use_preview = ASIDE["engine"], "sunfleck export", False

        def render(self, depsgraph: bpy.types.Depsgraph) -> None:
            try:
                seen.update(look(self, depsgraph, frames, shutter, job))
            except Exception as error:  # Blender would print it and go on.
                failed.append(error)

    with ExitStack() as stack:
        stack.enter_context(registered(SUNFLECK_RENDER_walk))
        stack.enter_context(settings_aside(scene))
        stack.enter_context(a_camera(scene))
        if is_simulated:
            # To the end of the last shutter.
            last = frames[-1] + math.ceil(shutter.opening + shutter.length)
            stack.enter_context(simulations.run(scene, layer, range(scene.frame_start, last + 1)))
        have_rendered(scene, layer)
    if failed:
        raise failed[0]
    if len(seen) < len(frames):
        raise Stopped(f"export was stopped after {len(seen)} of {len(frames)} frames")


def have_rendered(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> None:
    """Makes Blender call the engine."""
    bpy.ops.render.render(layer=layer.name, scene=scene.name)


def view_layer(scene: bpy.types.Scene) -> bpy.types.ViewLayer:
    """View layer to export: the current one if it renders, else the first that does."""
    at_hand = bpy.context.view_layer
    rendered = [layer for layer in scene.view_layers if layer.use]
    if bpy.context.scene == scene and (at_hand in rendered or not rendered):
        return at_hand
    return (rendered or list(scene.view_layers))[0]


@contextmanager
def registered(cls: type) -> Iterator[None]:
    bpy.utils.register_class(cls)
    try:
        yield
    finally:
        bpy.utils.unregister_class(cls)


@contextmanager
def settings_aside(scene: bpy.types.Scene) -> Iterator[None]:
    """Restores Blender's own settings and the frame afterwards."""
    render, frame = scene.render, (scene.frame_current, scene.frame_subframe)
    before = {name: getattr(render, name) for name in ASIDE}
    try:
        for name, value in ASIDE.items():
            setattr(render, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(render, name, value)
        scene.frame_set(frame[0], subframe=frame[1])


@contextmanager
def a_camera(scene: bpy.types.Scene) -> Iterator[None]:
    """Adds a camera, without which Blender does not render."""
    if scene.camera:
        yield
        return
    data = bpy.data.cameras.new("sunfleck walk")
    data[STAND_IN] = True
    scene.camera = bpy.data.objects.new("sunfleck walk", data)
    scene.camera.hide_render = True
    scene.collection.objects.link(scene.camera)
    try:
        yield
    finally:
        bpy.data.objects.remove(scene.camera)
        bpy.data.cameras.remove(data)
