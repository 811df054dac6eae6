"""Rendering of a scene by `sunfleck render`, with progress; without a window it blocks until the end."""

import json
import queue
import re
import subprocess
import threading
from pathlib import Path

import bpy
from bpy.props import BoolProperty

from . import export, extras, program

# Interval of polling with a window, seconds.
LOOK_S = 0.2
# Warning after the name of a file.
WARNING = re.compile(r"warning\[[a-z-]+\].*")


class Process:
    """Running program, with threads that read its output; subclasses define `_read_events`."""

    def __init__(self, *command, stdin=None):
        self.process = subprocess.Popen(
            command, stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8"
        )
        self.complaints = []
        readers = (self._read_events, self._read_complaints)
        self.readers = [threading.Thread(target=reader, daemon=True) for reader in readers]
        for reader in self.readers:
            reader.start()

    def _read_complaints(self):
        for line in self.process.stderr:
            self.complaints.append(line)

    def wait(self):
        """Waits for the exit code."""
        code = self.process.wait()
        for reader in self.readers:
            reader.join()
        for pipe in (self.process.stdout, self.process.stderr):
            pipe.close()
        return code


class Run(Process):
    """Run of `render`, whose events `news` returns."""

    def __init__(self, executable, glb, out, arguments=()):
        """`out` is a folder, or the path of a single frame."""
        out = str(out) if str(out).endswith(".exr") else f"{out}/"
        self.events = queue.SimpleQueue()
        super().__init__(executable, "render", str(glb), "--progress", "jsonl", "--out", out, *arguments)

    def _read_events(self):
        for line in self.process.stdout:
            self.events.put(json.loads(line))

    def news(self):
        """Events since the last call."""
        return drained(self.events)

    def is_over(self):
        return self.process.poll() is not None and not any(reader.is_alive() for reader in self.readers)

    def cancel(self):
        """Stops the run; whole frames are kept."""
        if self.process.poll() is None:
            self.process.terminate()
        self.wait()

    def error(self):
        """Error message of the program; empty if it succeeded."""
        return "" if self.process.poll() == 0 else "".join(self.complaints).strip() or "sunfleck failed"

    def warnings(self):
        """Warnings of a successful program, one a kind: losses, and doubtful frames."""
        found = (WARNING.search(line) for line in self.complaints if self.process.poll() == 0)
        return [warning[0] for warning in found if warning]


def drained(events):
    """Current contents of a queue."""
    found = []
    while not events.empty():
        found.append(events.get())
    return found


def flags(scene, animation, size=None):
    """Flags for Blender's render settings: this frame or those of the step, and the border."""
    found = [f"--frames={scene.frame_current}"]
    if animation:
        steps = f"--frames={scene.frame_start}..{scene.frame_end}:{scene.frame_step}"
        found = [steps] if scene.frame_step != 1 else []
    if not scene.render.use_border:
        return found
    crop = border(scene.render, *(size or extras.settings(scene)["resolution"]))
    return [*found, f"--crop={','.join(map(str, crop))}"]


def border(render, width, height):
    """First and last pixels of the render border: left, top, right, bottom."""
    left, right = (int(width * edge) for edge in (render.border_min_x, render.border_max_x))
    # Blender counts from the bottom, and drops partial pixels.
    top, bottom = (height - int(height * edge) for edge in (render.border_max_y, render.border_min_y))
    return left, top, max(right, left + 1), max(bottom, top + 1)


class SUNFLECK_OT_render(bpy.types.Operator):
    """Export this scene and render it with sunfleck; Esc stops it and keeps whole frames"""

    bl_idname = "sunfleck.render"
    bl_label = "Render with sunfleck"

    animation: BoolProperty(name="Animation", description="All frames, not only this one", default=False)

    def start(self, context):
        executable = program.find()
        if executable is None:
            self.report({"ERROR"}, program.MISSING)
            return False
        scene = context.scene
        folder = export.default_folder(scene)
        try:
            glb = export.make(folder)
            for warning in export.export(scene, glb, None if self.animation else scene.frame_current):
                self.report({"WARNING"}, warning)
        except export.NotExportable as error:
            self.report({"ERROR"}, str(error))
            return False
        self.run = Run(executable, glb, folder, flags(scene, self.animation))
        self.folder, self.total = folder, 1
        self.done, self.shown, self.fractions = 0, 0.0, {}
        return True

    def execute(self, context):
        if not self.start(context):
            return {"CANCELLED"}
        self.run.wait()
        return self.finish(context)

    def invoke(self, context, _event):
        if not self.start(context):
            return {"CANCELLED"}
        window_manager = context.window_manager
        self.timer = window_manager.event_timer_add(LOOK_S, window=context.window)
        window_manager.progress_begin(0.0, 1.0)
        window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.run.cancel()
            self.put_away(context)
            self.report({"WARNING"}, f"stopped; whole frames are in {self.folder}")
            return {"CANCELLED"}
        if event.type == "TIMER":
            for news in self.run.news():
                self.tell(context, news)
            if self.run.is_over():
                self.put_away(context)
                return self.finish(context)
        return {"PASS_THROUGH"}

    def cancel(self, context):
        """Called when Blender closes."""
        self.run.cancel()
        self.put_away(context)

    def tell(self, context, news):
        if news["event"] == "started":
            self.total = max(1, news["frames"])
        elif news["event"] in {"frame_written", "frame_skipped", "frame_given_up"}:
            self.done += 1
            self.fractions.pop(news["frame"], None)
        elif news["event"] == "frame_progress":
            self.fractions[news["frame"]] = news["fraction"]
        # Threads may report out of order; progress never goes back.
        done = self.done + sum(self.fractions.values())
        self.shown = max(self.shown, min(1.0, done / self.total))
        context.window_manager.progress_update(self.shown)
        context.workspace.status_text_set(f"sunfleck: {100.0 * self.shown:.0f} %, Esc stops")

    def put_away(self, context):
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def finish(self, context):
        error = self.run.error()
        if error:
            self.report({"ERROR"}, error)
            return {"CANCELLED"}
        for warning in self.run.warnings():
            self.report({"WARNING"}, warning)
        frames = sorted(Path(self.folder).glob("*.exr"))
        self.report({"INFO"}, f"{len(frames)} frames are in {self.folder}")
        if frames:
            bpy.ops.sunfleck.load_frames(filepath=str(frames[0]))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((SUNFLECK_OT_render,))
