"""A long sequence from a few rendered frames: copies, there and back again, each under its own number.

    python -m tests.many_frames ../out/few ../out/many --count 1000        (in tools/)
"""

import argparse
import struct
from collections.abc import Sequence
from pathlib import Path

from sunfleck_tools.sequence import list_sequence

COUNTER = b"imageCounter\0int\0" + struct.pack("<i", 4)


def multiply(sources: Sequence[Path], folder: Path, count: int, name: str = "many") -> None:
    """Writes frames 1 to `count` into `folder`, which is made; no two neighbours are equal."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = [path.read_bytes() for path in sources]
    there_and_back = [*pictures, *pictures[-2:0:-1]]
    for number in range(1, count + 1):
        data = there_and_back[(number - 1) % len(there_and_back)]
        at = data.index(COUNTER) + len(COUNTER)
        path = folder / f"{name}.{number:04d}.exr"
        path.write_bytes(data[:at] + struct.pack("<i", number) + data[at + 4 :])


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("source", type=Path, help="a folder of frames that sunfleck rendered, three at least")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=1000)
    arguments = parser.parse_args()
    multiply(
        [file.path for file in list_sequence(arguments.source).frames], arguments.folder, arguments.count
    )


if __name__ == "__main__":
    main()
