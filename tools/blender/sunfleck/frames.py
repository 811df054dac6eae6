"""Sequence of EXR frames as one multilayer image with passes."""

import re
from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ImportHelper

# Text before the frame's number, the number, the extension. A dash after other text separates, as in `leaf-0001`.
NUMBERED = re.compile(r"(|.*?[._]|.*?(?=\d))(-?\d+)(\.exr)$", re.IGNORECASE)


def siblings(path):
    """Numbers of all frames in the sequence of `path`."""
    match = NUMBERED.match(path.name)
    if not match:
        return []
    names = (NUMBERED.match(other.name) for other in path.parent.iterdir())
    return sorted(int(name[2]) for name in names if name and name[1] == match[1])


def load(path):
    """Image of the sequence, with its first and last frame."""
    if not Path(path).is_file():
        raise RuntimeError(f"{path} is no file: choose a frame")
    numbers = siblings(Path(path)) or [0]
    image = bpy.data.images.load(str(path), check_existing=True)
    image.reload()
    # Querying the size makes Blender read the file's layers, which it does not do for sequences.
    _ = image.size[:]
    if len(numbers) > 1:
        image.source = "SEQUENCE"
    return image, numbers[0], numbers[-1]


def show(context, image, first, last):
    """Shows an image in every image editor of the window."""
    areas = context.screen.areas if context.screen else ()
    for area in areas:
        if area.type == "IMAGE_EDITOR":
            area.spaces.active.image = image
            user = area.spaces.active.image_user
            user.frame_start, user.frame_duration = first, last - first + 1
            user.frame_offset, user.use_auto_refresh = first - 1, True


class SUNFLECK_OT_load_frames(bpy.types.Operator, ImportHelper):
    """Load rendered frames as an image sequence with its passes"""

    bl_idname = "sunfleck.load_frames"
    bl_label = "Load the frames"
    bl_options = {"REGISTER", "UNDO"}
    filename_ext = ".exr"
    filter_glob: StringProperty(default="*.exr", options={"HIDDEN"})

    def execute(self, context):
        try:
            image, first, last = load(self.filepath)
        except RuntimeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        show(context, image, first, last)
        self.report({"INFO"}, f"frames {first} to {last}: image `{image.name}`")
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((SUNFLECK_OT_load_frames,))
