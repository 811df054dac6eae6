"""*Sunfleck* in Blender's menu of render engines.

In goes Blender's dependency graph, out come pixels of its Render Result. `exporting` makes a file of the
graph, the program renders it, and `picture` copies its frame; `stepping` fills caches of simulations
before. Invariant: the pixels are those of the program's frame, to the bit; every failure is a report.
"""

import time

import bpy

from .. import program
from ..evaluated import walk
from ..film import ENGINE
from ..losses import by_kind
from . import exporting, looking, panels, passes, picture, stepping
from .aspect import Pixels
from .viewport import View, Viewport

# Interval for polling whether Blender wants to stop, seconds.
LOOK_S = 0.02
# Maximum share of time for intermediate pictures.
SHOWN_SHARE = 0.02


class SUNFLECK_RENDER_engine(bpy.types.RenderEngine):
    bl_idname, bl_label = ENGINE, "Sunfleck"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False
    # *Material Preview* uses Eevee, as with Cycles.
    bl_use_eevee_viewport = True

    def update_render_passes(self, scene=None, renderlayer=None):
        for name, channels, kind in passes.registered(scene, renderlayer):
            self.register_pass(scene, renderlayer, name, len(channels), channels, kind)

    def render(self, depsgraph):
        # Blender prints uncaught exceptions, and then claims to have rendered.
        try:
            self.rendered(depsgraph)
        except walk.Stopped:
            pass
        except exporting.NotRendered as problem:
            self.report({"ERROR"}, str(problem))
        except Exception as problem:
            self.report({"ERROR"}, f"{type(problem).__name__}: {problem}")

    def rendered(self, graph):
        executable = program.find()
        if executable is None:
            raise exporting.NotRendered(program.MISSING)
        self.update_stats("", "Sunfleck: exporting")
        kept = exporting.exported(self, graph)
        for finding in by_kind(kept.findings):
            self.report({"WARNING" if finding.severity == "WARNING" else "INFO"}, str(finding))
        if self.is_stopped():
            return
        pixels = Pixels(graph.scene.render, self.resolution_x, self.resolution_y)
        look = looking.Look(*pixels.square)
        try:
            run, frame = exporting.started(pixels, graph, kept, [executable, *look.flags])
            if not self.awaited(run, look, pixels, graph.view_layer.name):
                return
        finally:
            look.close()
        code = run.wait()
        if code:
            raise exporting.NotRendered(run.error())
        for warning in run.warnings():
            self.report({"WARNING"}, warning)
        picture.hand_over(self, graph.view_layer.name, pixels.of(picture.read(frame)))

    def awaited(self, run, look, pixels, layer):
        """Waits for the program, and shows intermediate pictures; returns whether it finished."""
        began, took = time.perf_counter(), 0.0
        while not run.is_over():
            if self.is_stopped():
                run.cancel()
                return False
            for news in run.news():
                if "fraction" in news:
                    self.update_progress(news["fraction"])
                    self.update_stats("", f"Sunfleck: {100.0 * news['fraction']:.0f} %")
            took = self.show_so_far(look, pixels, layer, took, time.perf_counter() - began)
            time.sleep(LOOK_S)
        return True

    def show_so_far(self, look, pixels, layer, took, elapsed):
        """Shows the picture so far, unless that takes too much time; returns the time spent so far."""
        so_far = look.newest() if took <= SHOWN_SHARE * elapsed else None
        if so_far is None:
            return took
        started = time.perf_counter()
        picture.show(self, layer, pixels.of(so_far))
        return took + time.perf_counter() - started

    def is_stopped(self):
        return self.test_break()

    def heed(self):
        """Raises to stop an export that was cancelled."""
        if self.is_stopped():
            raise walk.Stopped

    # For a viewport with *Rendered* shading, which has an engine of its own.

    def view_update(self, context, depsgraph):
        """Handles a change, or the first view."""
        try:
            shown = self.shown_in_viewport()
            changed = {update.id.original for update in depsgraph.updates}
            eye = depsgraph.scene.camera
            if shown.kept is None or not (eye and changed and changed <= {eye, eye.data}):
                shown.changed(depsgraph)
        except Exception as problem:
            self.report({"ERROR"}, f"{type(problem).__name__}: {problem}")

    def view_draw(self, context, depsgraph):
        try:
            shown, view = self.shown_in_viewport(), View.of(context)
            shown.look(view)
            is_more = shown.poll()
            self.update_stats("Sunfleck", shown.problem or ("" if is_more else "done"))
            self.draw_picture(depsgraph.scene, shown, view.size)
            if is_more:
                self.tag_redraw()
        except Exception as problem:
            self.report({"ERROR"}, f"{type(problem).__name__}: {problem}")

    def draw_picture(self, scene, shown, size):
        from .drawing import Drawn

        self.drawn = getattr(self, "drawn", None) or Drawn()
        self.drawn.draw(self, scene, shown, size)

    def shown_in_viewport(self):
        self.viewport = getattr(self, "viewport", None) or Viewport()
        return self.viewport


def register():
    bpy.utils.register_class(SUNFLECK_RENDER_engine)
    panels.register()
    stepping.register()


def unregister():
    stepping.unregister()
    panels.unregister()
    bpy.utils.unregister_class(SUNFLECK_RENDER_engine)
    exporting.forget()
