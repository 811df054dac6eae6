"""The graph that Blender renders as a file for the program.

In goes the graph, out come a file and what is lost. Invariant: with Blender's *Persistent Data*, nothing but
the camera is written anew while nothing but the camera has changed.
"""

import shutil
import tempfile
from pathlib import Path

import bpy

from .. import check, extras, render
from ..evaluated import places, scenes, values, walk
from ..losses import ordered
from ..materials.library import custom
from . import passes

# Losses of files that are none here: Blender itself does these.
DONE_BY_BLENDER = {"border", "view-layers", "frame-step", "compositor", "sequencer"}


class NotRendered(Exception):
    """Something stands in the way; the message says what."""


class Kept:
    """The last export of a view layer."""

    def __init__(self, path, frame, exported, findings):
        self.path, self.frame, self.exported, self.findings = path, frame, exported, findings


_kept = {}
# Of each view layer's file.
_numbers = {}
_folder = None


def folder():
    """Where files of this Blender lie."""
    global _folder
    if _folder is None or not _folder.is_dir():
        _folder = Path(tempfile.mkdtemp(prefix="sunfleck_", dir=bpy.app.tempdir or None))
    return _folder


def forget():
    """Nothing is kept."""
    global _folder
    _kept.clear()
    _numbers.clear()
    if _folder is not None:
        shutil.rmtree(_folder, ignore_errors=True)
        _folder = None


def exported(engine, graph):
    """The file, and what was found on the way."""
    scene, key = graph.scene, (graph.scene.name, graph.view_layer.name)
    kept = _kept.pop(key, None)
    if kept is None or not is_camera_alone(graph, kept):
        kept = anew(engine, graph, folder() / f"{_numbers.setdefault(key, len(_numbers))}.glb")
    else:
        put_camera(graph, kept)
    if scene.render.use_persistent_data:
        _kept[key] = kept
    return kept.path, kept.findings


def anew(engine, graph, path):
    scene, frame = graph.scene, graph.scene.frame_current
    findings = [one for one in check.check(scene) if one.id not in DONE_BY_BLENDER]
    errors = [str(finding) for finding in findings if finding.severity == "ERROR"]
    if errors:
        raise NotRendered("; ".join(errors))
    try:
        with scenes.Job(scene, frame) as job:
            see(engine, graph, job)
            said = {**custom(scene), **extras.of_scene(scene, path)}
            made = job.written(path, graph.view_layer, said)
    except (OSError, RuntimeError) as problem:
        raise NotRendered(str(problem).strip()) from problem
    return Kept(path, frame, made, ordered([*findings, *made.findings]))


def see(engine, graph, job):
    """The frame at hand, what the shutter sees of it, and what the motion pass needs; then the frame again."""
    frame, is_moving = graph.scene.frame_current, "motion" in passes.wanted(graph.scene, graph.view_layer)
    if not job.shutter.length and not is_moving:
        job.visit(graph, frame, 0.0)
        return
    for _ in walk.look(engine, graph, job.frames, job.shutter, job):
        pass
    for step in (-1, 1) if is_moving else ():
        engine.frame_set(frame + step, 0.0)
        job.visit(graph, frame, float(step))
    engine.frame_set(frame, 0.0)


def is_camera_alone(graph, kept):
    """Whether a file is right but for its camera."""
    scene, eye = graph.scene, graph.scene.camera
    if eye is None or scene.frame_current != kept.frame or len(kept.exported.record.moments) > 1:
        return False
    # Hair turns to the camera.
    if kept.exported.record.capture.eyes or camera_key(kept, eye) is None:
        return False
    changed = {update.id.original for update in graph.updates}
    return changed <= {eye, eye.data}


def camera_key(kept, eye):
    """Of the camera's node, if it is one of an object by itself."""
    things = kept.exported.record.things.items()
    found = [key for key, thing in things if thing.object == eye and thing.instancer is None]
    return found[0] if len(found) == 1 and found[0] in kept.exported.assembly.nodes else None


def put_camera(graph, kept):
    """The camera's place and lens, in the file that there is."""
    scene, assembly = graph.scene, kept.exported.assembly
    eye = scene.camera.evaluated_get(graph)
    document, view = assembly.document, values.View(kept.frame, scene.camera, eye, scene)
    node = document.lists["nodes"][assembly.nodes[camera_key(kept, scene.camera)]]
    parts = places.parts(places.in_gltf(view.matrix[None], looks=True))
    for name in ("translation", "rotation", "scale"):
        node[name] = getattr(parts, name)[0].tolist()
    assembly.look(node, None, view.said)
    document.write(kept.path)


def flags(engine, scene, layer):
    """What the program is told beside the file."""
    found = [f"--size={engine.resolution_x}x{engine.resolution_y}"]
    found += [f"--passes={','.join(passes.wanted(scene, layer)) or 'none'}"]
    if scene.render.threads_mode == "FIXED":
        found.append(f"--threads={scene.render.threads}")
    return [*found, *render.flags(scene, animation=False, size=(engine.resolution_x, engine.resolution_y))]
