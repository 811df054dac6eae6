"""Export of Blender's graph as a file for the program.

In goes the graph, out come a file, its losses, and the program that renders it. Invariant: with Blender's
*Persistent Data*, nothing is written or loaded again while only the camera changes. While objects only
move and lights change, no mesh is exported again.
"""

import copy
import shutil
import tempfile
from pathlib import Path

import bpy

from .. import check, extras, film, render, service
from ..evaluated import scenes, values, walk
from ..evaluated.moments import Shutter
from ..losses import Finding, ordered
from ..stored import by_hand
from . import passes, patching

# Losses of files that do not apply here: Blender handles these itself, or each frame has its own.
DONE_BY_BLENDER = {"border", "pixel-aspect", "view-layers", "frame-step", "compositor", "sequencer", "view-transform"}
OF_EACH_FRAME = {"world-changes", "film-exposure-changes", "shutter-changes", "camera-cuts", "visibility-changes"}


class NotRendered(Exception):
    """The scene cannot be rendered; the message has the reason."""


class Kept:
    """Last export of a view layer."""

    def __init__(self, path, graph, exported, findings, said):
        scene, layer = graph.scene, graph.view_layer
        self.path, self.frame, self.exported, self.findings = path, scene.frame_current, exported, findings
        # Custom properties of the scene: as written, and as set in panels.
        self.said, self.told = said, told(scene, layer)
        # Program with this file loaded, and the camera that replaces the file's.
        self.service = self.camera = None

    def close(self):
        if self.service is not None:
            self.service.close()
            self.service = None


_kept = {}
# Numbers of each view layer's file.
_numbers = {}
_folder = None


def folder():
    """Folder of this Blender's files."""
    global _folder
    if _folder is None or not _folder.is_dir():
        _folder = Path(tempfile.mkdtemp(prefix="sunfleck_", dir=bpy.app.tempdir or None))
    return _folder


def forget():
    """Drops all exports."""
    global _folder
    while _kept:
        _kept.popitem()[1].close()
    _numbers.clear()
    if _folder is not None:
        shutil.rmtree(_folder, ignore_errors=True)
        _folder = None


def exported(engine, graph):
    """Exported file and its findings: `Kept`."""
    scene, key = graph.scene, (graph.scene.name, graph.view_layer.name)
    kept = _kept.pop(key, None)
    path = folder() / f"{_numbers.setdefault(key, len(_numbers))}.glb"
    if kept is not None and is_as_told(graph, kept):
        if not is_camera_alone(graph, kept):
            kept.close()
            kept = patched(graph, kept)
        if kept is not None:
            put_camera(graph, kept)
    elif kept is not None:
        kept.close()
        kept = None
    kept = kept or anew(engine, graph, path)
    if scene.render.use_persistent_data:
        _kept[key] = kept
    return kept


def told(scene, layer):
    """Panel settings of a scene and its layer."""
    override = layer.material_override
    said = {"override": override and override.name_full, "film": film.exposure(scene)}
    return {**by_hand(scene), **extras.of_scene(scene), **said}


def is_as_told(graph, kept):
    """Whether the moments and all settings without notifications are unchanged."""
    scene = graph.scene
    is_still = not Shutter.of(scene).length and "motion" not in passes.wanted(scene, graph.view_layer)
    eye = scene.camera
    return is_still and told(scene, graph.view_layer) == kept.told and eye is not None and camera_key(kept, eye) is not None


def patched(graph, kept):
    """The same export with changes applied; None if it has to be made again."""
    if not patching.put(graph, kept):
        return None
    refuse(kept.findings)
    kept.exported.assembly.document.write(kept.path)
    return kept


def refuse(findings):
    errors = [str(finding) for finding in findings if finding.severity == "ERROR"]
    if errors:
        raise NotRendered("; ".join(errors))


def anew(engine, graph, path):
    scene, frame = graph.scene, graph.scene.frame_current
    findings = check.check(scene)
    lacking = passes.lacking(graph.view_layer)
    findings += [Finding("layer-passes", f"`{graph.view_layer.name}`", ", ".join(lacking))] if lacking else []
    refuse(findings)
    try:
        with scenes.Job(scene, frame) as job:
            job.record.capture.heed = engine.heed
            see(engine, graph, job)
            findings += check.of_shown(job.record.originals(), scene)
            refuse(findings)
            said = {**by_hand(scene), **extras.of_scene(scene, path)}
            made = job.written(path, graph.view_layer, copy.deepcopy(said))
    except (OSError, RuntimeError) as problem:
        raise NotRendered(str(problem).strip()) from problem
    findings = [one for one in findings if one.id not in DONE_BY_BLENDER | OF_EACH_FRAME]
    return Kept(path, graph, made, ordered([*findings, *made.findings]), said)


def see(engine, graph, job):
    """Visits the current frame, the shutter's moments, and those of the motion pass; then the frame again."""
    frame, is_moving = graph.scene.frame_current, "motion" in passes.wanted(graph.scene, graph.view_layer)
    if not job.shutter.length and not is_moving:
        job.visit(graph, frame, 0.0)
        return
    clock = Clock(engine, graph.scene.frame_subframe)
    for _ in walk.look(clock, graph, job.frames, job.shutter, job):
        pass
    for step in (-1, 1) if is_moving else ():
        clock.frame_set(frame + step, 0.0)
        job.visit(graph, frame, float(step))
    clock.frame_set(frame, 0.0)


class Clock:
    """Clock of an engine at a frame with a fraction."""

    def __init__(self, engine, late):
        self.engine, self.late = engine, late

    def frame_set(self, frame, part):
        whole, part = divmod(frame + part + self.late, 1.0)
        self.engine.frame_set(int(whole), part)


def is_camera_alone(graph, kept):
    """Whether only the camera of a file has changed."""
    scene, eye = graph.scene, graph.scene.camera
    # Hair faces the camera.
    if scene.frame_current != kept.frame or kept.exported.record.capture.eyes:
        return False
    changed = {update.id.original for update in graph.updates}
    return changed <= {eye, eye.data}


def camera_key(kept, eye):
    """Key of the camera's node, if it belongs to a plain object."""
    things = kept.exported.record.things.items()
    found = [key for key, thing in things if thing.object == eye and thing.instancer is None]
    return found[0] if len(found) == 1 and found[0] in kept.exported.assembly.nodes else None


def put_camera(graph, kept):
    """Sets the camera's placement and lens, which the program gets beside the file."""
    eye = graph.scene.camera.evaluated_get(graph)
    view = values.View(kept.frame, graph.scene.camera, eye, graph.scene)
    kept.camera = service.viewer(view.matrix, {**view.said.camera, "extras": view.said.extras})


def started(pixels, graph, kept, command):
    """Starts the program on a picture of `Pixels`, for this one alone or with a loaded scene; returns the run and
    the path of its frame. `command` is the program and its flags."""
    executable, *told = command
    scene, frame = graph.scene, kept.path.with_suffix(".exr")
    threads = [f"--threads={scene.render.threads}"] if scene.render.threads_mode == "FIXED" else []
    wanted = [*flags(pixels, scene, graph.view_layer), *told]
    if not scene.render.use_persistent_data:
        return render.Run(executable, kept.path, frame, [*wanted, *threads]), frame
    if kept.service is None or not kept.service.is_alive():
        kept.service = service.Service(executable, kept.path, threads)
    return kept.service.render([*wanted, f"--out={frame}"], kept.camera), frame


def flags(pixels, scene, layer):
    """Flags for the program."""
    passes_wanted = ",".join(passes.wanted(scene, layer)) or "none"
    return [f"--frames={scene.frame_current}", f"--passes={passes_wanted}", *pixels.flags()]
