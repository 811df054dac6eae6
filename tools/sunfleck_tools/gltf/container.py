"""Container of a glTF file. In goes a path, out come JSON and bytes of buffers.

Invariant: only existing bytes are returned, and memory is not allocated by a file's declarations.
"""

import base64
import binascii
import json
import os
import struct
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import unquote

from ..disk import need_regular
from ..errors import SceneError
from .values import Value

LARGEST_FILE = 2**32  # what glTF's container can count
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
DISPLAY_PICTURES = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg"}
LINEAR_PICTURES = {b"\x76\x2f\x31\x01": ".exr", b"#?": ".hdr"}
"""First bytes of files, and their names' endings."""


class Container:
    """Opened file: its document, and its buffers on demand. Other files are read from its own folder, or
    from the allowed ones."""

    def __init__(self, path: Path, allowed: Sequence[Path] = ()):
        self.path = path
        self._folders = [folder.resolve() for folder in (path.parent, *allowed)]
        data = read_bytes(path)
        self._binary: bytes | None = None
        if data[:4] == b"glTF":
            data, self._binary = chunks(data, path)
        try:
            document = json.loads(data.decode("utf-8-sig"))
        except RecursionError:
            raise SceneError(f"{path}: is no glTF: its JSON is nested too deeply") from None
        except ValueError as error:
            raise SceneError(f"{path}: is no glTF: its JSON cannot be read: {error}") from None
        self.document = Value(document, str(path))
        version = self.document.need("asset").text_at("version")
        if version.split(".")[0] != "2":
            self.document.need("asset").fail(f"version `{version}` is not read, only 2.0")
        self._buffers: dict[int, bytes] = {}
        self._described = self.document.items("buffers")
        self._views = self.document.items("bufferViews")

    def buffer(self, index: int) -> bytes:
        """Bytes of a buffer."""
        if index not in self._buffers:
            described = self._described[index]
            length = described.need("byteLength").whole()
            uri = described.member("uri")
            data = self._binary if uri is None and index == 0 else None if uri is None else self.linked(uri)
            if data is None:
                described.fail("has neither a uri nor a binary chunk")
            if len(data) < length:
                described.fail(f"has {len(data)} bytes, not {length}: the file is cut short")
            self._buffers[index] = data[:length]
        return self._buffers[index]

    def linked(self, uri: Value) -> bytes:
        """Bytes of a URI."""
        text = uri.text()
        if text.startswith("data:"):
            try:
                return base64.b64decode(text.partition(",")[2], validate=True)
            except binascii.Error:
                uri.fail("is no base64")
        if "://" in text or "\0" in text:
            uri.fail("only data and files beside this one are read")
        path = self.path.parent / unquote(text)
        try:
            real = path.resolve()
        except (OSError, RuntimeError):  # links in a circle
            uri.fail(f"leads to {path}, which cannot be found")
        if not any(real.is_relative_to(folder) for folder in self._folders):
            uri.fail(
                f"leads out of the file's folder, to {path}: if that is meant, give --allow {path.parent}"
            )
        return read_bytes(path)

    def beside(self, uri: Value) -> Path:
        """File of a URI, by its own folder: that of the renderer's export, which is temporary, may be gone."""
        return Path(os.path.realpath(self.path.parent / unquote(uri.text())))

    def picture(self, image: Value) -> bytes:
        """Bytes of an image's file."""
        if (view := image.member("bufferView")) is None:
            return self.linked(image.need("uri"))
        data, start, length, _ = self.view(view)
        return data[start : start + length]

    def view(self, index: Value) -> tuple[bytes, int, int, int]:
        """Buffer, first byte, length and stride (0 if tight) of a buffer view."""
        view = index.item_of(self._views, "buffer view")
        data = self.buffer(view.need("buffer").index(self._described, "buffer"))
        start, length = int(view.number_at("byteOffset", 0, 0)), view.need("byteLength").whole()
        if start + length > len(data):
            view.fail(f"ends at byte {start + length} of {len(data)}")
        return data, start, length, int(view.number_at("byteStride", 0, 0, 65536))


def ending_of(data: bytes, kinds: dict[bytes, str], of: Value, what: str) -> str:
    """Ending of a picture's name by its first bytes; other pictures of `of` fail."""
    ending = next((ending for start, ending in kinds.items() if data.startswith(start)), None)
    return ending or of.fail(what)


def read_bytes(path: Path) -> bytes:
    """A whole file, up to a maximum size."""
    try:
        size = need_regular(path)
        if size > LARGEST_FILE:
            raise SceneError(f"{path}: has {size} bytes, more than glTF can count")
        return path.read_bytes()
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None


def chunks(data: bytes, path: Path) -> tuple[bytes, bytes | None]:
    """JSON and binary chunk of a .glb (specification, 4.4)."""
    found: dict[int, bytes] = {}
    at = 12
    while at + 8 <= len(data):
        length, kind = struct.unpack_from("<II", data, at)
        if at + 8 + length > len(data):
            raise SceneError(f"{path}: is cut short: a chunk of {length} bytes has {len(data) - at - 8}")
        found.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    if JSON_CHUNK not in found:
        raise SceneError(f"{path}: holds no JSON chunk")
    return found[JSON_CHUNK], found.get(BINARY_CHUNK)
