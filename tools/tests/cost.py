"""What `validate` costs beside decoding alone: processor time over a folder, in turns of a few frames.

A machine that others use too is then as slow for one as for the other.

    python -m tests.cost ../out/many        (in tools/; tests.many_frames makes such a folder)
"""

import argparse
import multiprocessing
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import OpenEXR

from sunfleck_tools import Options, validate
from sunfleck_tools.exr.pixel_hash import pixel_hash
from sunfleck_tools.memory import keep_freed_memory
from sunfleck_tools.sequence import list_sequence

FRAMES_A_TURN = 50


def decoded(path: Path) -> dict:
    """Pixels by OpenEXR, as its users get them."""
    part = OpenEXR.File(str(path), separate_channels=True)
    return {name: channel.pixels for name, channel in part.channels().items()}


def decode_only(folder: Path) -> None:
    """The least that there is to do."""
    for path in sorted(folder.iterdir()):
        decoded(path)


def decode_and_hash(folder: Path) -> None:
    """The least that finds damage in every compression."""
    for path in sorted(folder.iterdir()):
        pixel_hash(decoded(path))


def validated(folder: Path) -> None:
    """Everything, from names to the report."""
    validate(folder, Options(processes=0))


def validated_with_thumbnails(folder: Path) -> None:
    """What `--html` does."""
    validate(folder, Options(processes=0, thumbnails=True))


WORKS = {
    "decoding alone": (decode_only, None),
    "decoding, freed memory kept": (decode_only, keep_freed_memory),
    "decoding and hash, likewise": (decode_and_hash, keep_freed_memory),
    "validate": (validated, keep_freed_memory),
    "validate, with thumbnails": (validated_with_thumbnails, keep_freed_memory),
}
"""What is done, and what its process does first: the last three as `validate`'s own processes."""


def seconds(work, folder: Path) -> float:
    """Of a processor, in this process."""
    began = time.process_time()
    work(folder)
    return time.process_time() - began


def turns(source: Path, scratch: Path) -> list[Path]:
    """The frames as folders of a few each."""
    folders = []
    for index, file in enumerate(list_sequence(source).frames):
        if index % FRAMES_A_TURN == 0:
            folders.append(scratch / f"{len(folders):04d}")
            folders[-1].mkdir()
        (folders[-1] / file.path.name).symlink_to(file.path.resolve())
    return folders


def main() -> None:
    """Prints a line for each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    spent = dict.fromkeys(WORKS, 0.0)
    with tempfile.TemporaryDirectory() as scratch:
        folders = turns(arguments.folder, Path(scratch))
        frames = sum(1 for folder in folders for _ in folder.iterdir())
        context = multiprocessing.get_context("spawn")
        pools = {name: ProcessPoolExecutor(1, context, start) for name, (_, start) in WORKS.items()}
        # The first turn twice: what is done once, such as imports, is no frame's.
        for warm, folder in [(False, folders[0]), *((True, folder) for folder in folders)]:
            for name, (work, _) in WORKS.items():
                took = pools[name].submit(seconds, work, folder).result()
                spent[name] += took if warm else 0.0
        for pool in pools.values():
            pool.shutdown()
    print(f"{frames} frames, {FRAMES_A_TURN} a turn")
    alone = spent["decoding alone"]
    for name, total in spent.items():
        print(
            f"{name:28} {total:7.1f} s of a processor ({1e3 * total / frames:.1f} ms a frame, "
            f"{total / alone:.2f})"
        )


if __name__ == "__main__":
    main()
