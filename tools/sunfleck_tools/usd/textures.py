"""Images of a glTF file as files beside a stage. Invariant: each image has one file, and only images that
are used have one."""

from pathlib import Path

import numpy as np

from ..exr.write import write_colors
from ..gltf.container import Container
from ..gltf.values import Value
from .prims import Names

KINDS = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg"}
SKY_KINDS = {b"\x76\x2f\x31\x01": ".exr", b"#?": ".hdr"}


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
            data = self._bytes(image)
            ending = next((ending for start, ending in KINDS.items() if data.startswith(start)), None)
            if ending is None:
                image.fail("is neither PNG nor JPEG")
            stem = Path(image.text_at("name") or f"image {number}").stem
            name = self.names.new(stem) + ending
            self.folder.mkdir(exist_ok=True)
            (self.folder / name).write_bytes(data)
            self._files[number] = f"./{self.name}/{name}"
        return self._files[number]

    def sky_file(self, uri: Value) -> str:
        """Path, relative to the stage, of a linear picture that a file links to."""
        data = self.container.linked(uri)
        ending = next((ending for start, ending in SKY_KINDS.items() if data.startswith(start)), None)
        if ending is None:
            uri.fail("is neither OpenEXR nor Radiance HDR")
        name = self.names.new("sky") + ending
        self.folder.mkdir(exist_ok=True)
        (self.folder / name).write_bytes(data)
        return f"./{self.name}/{name}"

    def picture_file(self, stem: str, pixels: np.ndarray) -> str:
        """Path, relative to the stage, of a linear picture that is written as OpenEXR."""
        name = self.names.new(stem) + ".exr"
        self.folder.mkdir(exist_ok=True)
        write_colors(self.folder / name, pixels)
        return f"./{self.name}/{name}"

    def _bytes(self, image: Value) -> bytes:
        if (view := image.member("bufferView")) is not None:
            data, start, length, _ = self.container.view(view)
            return data[start : start + length]
        return self.container.linked(image.need("uri"))
