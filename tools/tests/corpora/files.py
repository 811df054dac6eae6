"""The files of a corpus, by kind."""

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

KIND_OF_SUFFIX = {
    ".gltf": "gltf", ".glb": "gltf", ".obj": "obj", ".exr": "exr",
    ".usd": "usd", ".usda": "usd", ".usdc": "usd", ".usdz": "usd",
}  # fmt: skip
KINDS = tuple(dict.fromkeys(KIND_OF_SUFFIX.values()))


@dataclass(frozen=True)
class CorpusFile:
    """A file; `name` is its path from the corpus's folder on, with slashes."""

    path: Path
    name: str
    kind: str
    is_invalid: bool = False
    """Its format forbids it, so that a refusal is right."""


def find_files(
    folder: Path, kinds: Collection[str] = KINDS, invalid: Collection[str] = ()
) -> list[CorpusFile]:
    """All files of these kinds below the folder, ordered by name; those named in `invalid` are marked.
    Follows no links."""
    found = []
    for path in folder.rglob("*"):
        kind = KIND_OF_SUFFIX.get(path.suffix.lower())
        if kind is not None and kind in kinds and path.is_file():
            name = path.relative_to(folder).as_posix()
            found.append(CorpusFile(path, name, kind, name in invalid))
    return sorted(found, key=lambda file: file.name)
