"""The dependency graph as a render sees it, at every moment of every frame.

Only a render engine is given a graph of what renders (not of what the viewport shows), so there is one here
that renders nothing: it looks. In go a scene and a visitor, which is called with the graph at each moment.
Invariant: afterwards the scene is as before.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Protocol

import bpy

from . import simulations
from .moments import Shutter

# What of Blender's render settings stands between a graph and whoever looks.
ASIDE = {"engine": "SUNFLECK_WALK", "use_compositing": False, "use_sequencer": False, "use_multiview": False}


class Stopped(Exception):
    """Someone stopped Blender before it had been through all frames."""


class Job(Protocol):
    """What looks."""

    def visit(self, graph: bpy.types.Depsgraph, frame: int, moment: float) -> None:
        """Sees the graph at a moment of a frame, which counts from that."""

    def is_smooth(self) -> bool:
        """Whether no more moments of the last frame are wanted."""


def look(
    engine: bpy.types.RenderEngine, graph: bpy.types.Depsgraph, frames: Sequence[int], shutter: Shutter, job: Job
) -> Iterator[int]:
    """Calls `job.visit(graph, frame, moment)` from within an engine, of every frame first the frame itself, in
    order: simulations know no other. Further moments of an open shutter are looked at until `job.is_smooth()`."""
    scene = graph.scene
    is_simulated = simulations.any_in(scene)
    for frame in frames:
        for number, moments in enumerate(shutter.rounds()):
            if number > 1 and job.is_smooth():
                break
            for moment in moments:
                # Before the first frame simulations know nothing.
                if is_simulated and frame + moment < scene.frame_start:
                    continue
                whole = math.floor(frame + moment)
                engine.frame_set(whole, frame + moment - whole)
                job.visit(graph, frame, moment)
        yield frame


def walk(scene: bpy.types.Scene, frames: Sequence[int], shutter: Shutter, job: Job) -> None:
    """The same by an engine of its own."""
    layer = view_layer(scene)
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
            # As far as the last shutter reaches.
            last = frames[-1] + math.ceil(shutter.opening + shutter.length)
            stack.enter_context(simulations.run(scene, layer, range(scene.frame_start, last + 1)))
        have_rendered(scene, layer)
    if failed:
        raise failed[0]
    if len(seen) < len(frames):
        raise Stopped(f"export was stopped after {len(seen)} of {len(frames)} frames")


def have_rendered(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> None:
    """Blender calls the engine."""
    bpy.ops.render.render(layer=layer.name, scene=scene.name)


def view_layer(scene: bpy.types.Scene) -> bpy.types.ViewLayer:
    """The layer that is exported: the one at hand if it renders, else the first that does."""
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
    """Blender's own settings come back, and the frame."""
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
    """Blender renders nothing without one."""
    if scene.camera:
        yield
        return
    data = bpy.data.cameras.new("sunfleck walk")
    scene.camera = bpy.data.objects.new("sunfleck walk", data)
    scene.camera.hide_render = True
    scene.collection.objects.link(scene.camera)
    try:
        yield
    finally:
        bpy.data.objects.remove(scene.camera)
        bpy.data.cameras.remove(data)
