"""Images of a glTF file as files beside a stage. Invariant: each image has one file, and only images that
are used have one."""

from pathlib import Path

import numpy as np

from ..exr.write import write_colors
from ..gltf.container import DISPLAY_PICTURES, LINEAR_PICTURES, Container, ending_of
from ..gltf.values import Value
from .prims import Names


class Textures:
    """Writes images into `folder`, whose name in the stage is `name`."""

    def __init__(self, container: Container, folder: Path, name: str):
        self.container, self.folder, self.name = container, folder, name
        self.images = container.document.items("images")
        self.names = Names()
        self._files: dict[int, str] = {}

    def file_of(self, texture: Value) -> str:
        """Path, relative to the stage, of a texture's image."""
        source = texture.member("source")
        if source is None:
            texture.fail("has no image that is PNG or JPEG")
        number = source.index(self.images, "image")
        if number not in self._files:
            image = self.images[number]
            data = self.container.picture(image)
            ending = ending_of(data, DISPLAY_PICTURES, image, "is neither PNG nor JPEG")
            self._files[number] = self._written(Path(image.text_at("name") or f"image {number}").stem, ending, data)
        return self._files[number]

    def sky_file(self, uri: Value) -> str:
        """Path, relative to the stage, of a linear picture that a file links to."""
        data = self.container.linked(uri)
        return self._written("sky", ending_of(data, LINEAR_PICTURES, uri, "is neither OpenEXR nor Radiance HDR"), data)

    def picture_file(self, stem: str, pixels: np.ndarray) -> str:
        """Path, relative to the stage, of a linear picture that is written as OpenEXR."""
        path = self._new(stem, ".exr")
        write_colors(path, pixels)
        return f"./{self.name}/{path.name}"

    def _written(self, stem: str, ending: str, data: bytes) -> str:
        path = self._new(stem, ending)
        path.write_bytes(data)
        return f"./{self.name}/{path.name}"

    def _new(self, stem: str, ending: str) -> Path:
        self.folder.mkdir(exist_ok=True)
        return self.folder / (self.names.new(stem) + ending)
