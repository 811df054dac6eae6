"""Export of a scene to a .glb file for sunfleck: check, custom properties, evaluated scene."""

import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper

from . import check, extras
from .evaluated import scenes, walk
from .evaluated.readback import File
from .losses import by_kind, ordered


class NotExportable(Exception):
    """The scene cannot be exported; the message has the reason."""


def export(scene, path, only=None):
    """Writes the file, with all frames or a single one; returns findings as warnings, one a kind."""
    found = by_kind(exported(scene, path, only).findings)
    return [str(finding) for finding in found if finding.severity == "WARNING"]


@dataclass
class Told:
    """Findings, visible counts by frame, and the state of materials."""

    findings: list
    counts: object
    # Sentence for each material.
    materials: dict


def exported(scene, path, only=None):
    """Writes the file, and reads it back."""
    # A script may just have set placements.
    walk.view_layer(scene).update()
    if Path(path).suffix.lower() != ".glb":
        raise NotExportable(f"{path} is not the name of a .glb file, which is what is written: let it end in .glb")
    findings = check.check(scene)
    refuse(findings)

    def judge(shown):
        findings.extend(check.of_shown(shown, scene))
        refuse(findings)

    try:
        extras.store(scene, path)
        made = scenes.export(scene, path, only, judge)
    # Blender raises `RuntimeError` with a message for users, for example about unwritable pictures.
    except (walk.Stopped, OSError, RuntimeError) as problem:
        raise NotExportable(str(problem).strip()) from problem
    expected, differences = made.compared(File(path))
    return Told(ordered([*findings, *made.findings, *differences]), expected, made.materials)


def refuse(findings):
    errors = [str(finding) for finding in findings if finding.severity == "ERROR"]
    if errors:
        raise NotExportable("; ".join(errors))


def make(folder):
    """Makes a folder for frames; returns the path of the file that goes there, with its pictures apart from the frames."""
    inner = folder / "scene"
    try:
        inner.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise NotExportable(f"the folder {inner} cannot be made: {problem.strerror}") from problem
    return inner / f"{folder.name}.glb"


class SUNFLECK_OT_export(bpy.types.Operator, ExportHelper):
    """Write this scene as a .glb file for sunfleck"""

    bl_idname = "sunfleck.export"
    bl_label = "Export for sunfleck"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".glb"
    filter_glob: StringProperty(default="*.glb", options={"HIDDEN"})

    def execute(self, context):
        try:
            findings = exported(context.scene, self.filepath).findings
        except NotExportable as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for finding in by_kind(findings):
            self.report({finding.severity}, str(finding))
        self.report({"INFO"}, f"wrote {self.filepath}")
        return {"FINISHED"}


class SUNFLECK_OT_check(bpy.types.Operator):
    """Say what of this scene would be lost, and compare what a file would show with what Blender shows"""

    bl_idname = "sunfleck.check"
    bl_label = "Check for sunfleck"

    def execute(self, context):
        try:
            told = checked(context.scene)
        except NotExportable as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for finding in by_kind(told.findings):
            self.report({finding.severity}, str(finding))
        if not told.findings:
            self.report({"INFO"}, "nothing will be lost")
        return {"FINISHED"}


def checked(scene):
    """The same with a temporary file."""
    with tempfile.TemporaryDirectory() as folder:
        return exported(scene, Path(folder) / "scene.glb")


def default_folder(scene):
    """Folder of frames: beside the .blend file, else a temporary one. Scenes of one file have their own."""
    stem = Path(bpy.data.filepath).stem or scene.name
    named = f"{stem}_{scene.name}" if len(bpy.data.scenes) > 1 and bpy.data.filepath else stem
    stem = re.sub(r"[^\w.-]+", "_", named)
    beside = Path(bpy.data.filepath).parent if bpy.data.filepath else Path(bpy.app.tempdir)
    return beside / "sunfleck" / stem


def menu(self, _context):
    self.layout.operator(SUNFLECK_OT_export.bl_idname, text="sunfleck (.glb)")


register_classes, unregister_classes = bpy.utils.register_classes_factory((SUNFLECK_OT_export, SUNFLECK_OT_check))


def register():
    register_classes()
    bpy.types.TOPBAR_MT_file_export.append(menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(menu)
    unregister_classes()
