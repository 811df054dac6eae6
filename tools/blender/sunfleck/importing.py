"""Import of a file from `sunfleck export` into the scene, at its own frame rate.

Blender's glTF importer multiplies seconds by `fps * fps_base`, although the frame rate is `fps /
fps_base`: at 24000/1001 frames a second keys are off by two thousandths. So the import runs with a base
that corrects the product, and the scene gets its own rate afterwards. Invariant: a key at a frame of the
file is at that frame in Blender.
"""

import json
import math
import struct
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ImportHelper


class NotImportable(Exception):
    """The file is not glTF; the message has the reason."""


def load(scene, path):
    """Imports the file, and sets the scene's rate, frames, size and camera. Returns the objects."""
    said = settings(Path(path))
    numerator, denominator = float(said.get("fps", 24.0)), float(said.get("fps_base", 1.0))
    rate = numerator / denominator
    whole = max(1, math.ceil(rate - 1e-6))
    before = set(bpy.data.objects)
    render = scene.render
    render.fps, render.fps_base = whole, rate / whole
    bpy.ops.import_scene.gltf(filepath=str(path))
    render.fps_base = whole / rate
    if "frame_start" in said and "frame_end" in said:
        scene.frame_start, scene.frame_end = round(said["frame_start"]), round(said["frame_end"])
    if "resolution" in said:
        render.resolution_x, render.resolution_y = (round(side) for side in said["resolution"])
        render.resolution_percentage = 100
    made = [thing for thing in bpy.data.objects if thing not in before]
    cameras = [thing for thing in made if thing.type == "CAMERA"]
    named = [thing for thing in cameras if said.get("camera") in {thing.name, thing.data.name}]
    scene.camera = next(iter(named or cameras), scene.camera)
    return made


def settings(path):
    """Custom property `sunfleck` of the file's scene, if it has one."""
    data = path.read_bytes()
    try:
        if data[:4] == b"glTF":
            (length,) = struct.unpack_from("<I", data, 12)
            data = data[20 : 20 + length]
        document = json.loads(data)
        scenes = document.get("scenes", [])
        extras = scenes[document.get("scene", 0)].get("extras", {}) if scenes else {}
        return extras.get("sunfleck", {})
    except (AttributeError, IndexError, TypeError, ValueError, struct.error) as error:
        raise NotImportable(f"{path.name} is not a glTF file: {error}") from error


class SUNFLECK_OT_import(bpy.types.Operator, ImportHelper):
    """Read a .glb file that sunfleck wrote, at its own frame rate"""

    bl_idname = "sunfleck.import_scene"
    bl_label = "Import from sunfleck"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".glb"
    filter_glob: StringProperty(default="*.glb;*.gltf", options={"HIDDEN"})

    def execute(self, context):
        try:
            made = load(context.scene, self.filepath)
        except (NotImportable, OSError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{len(made)} objects from {self.filepath}")
        return {"FINISHED"}


def menu(self, _context):
    self.layout.operator(SUNFLECK_OT_import.bl_idname, text="sunfleck (.glb)")


def register():
    bpy.utils.register_class(SUNFLECK_OT_import)
    bpy.types.TOPBAR_MT_file_import.append(menu)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(menu)
    bpy.utils.unregister_class(SUNFLECK_OT_import)
