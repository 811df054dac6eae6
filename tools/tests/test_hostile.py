"""Files that were made to hurt: `validate` ends with sentences, in little memory, and never
with a traceback."""

import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
from collections.abc import Callable
from pathlib import Path

from sunfleck_tools.exr.header import parse_header

from .files import DATA, frame_path, good_sequence, rewrite

MEMORY_LIMIT = 2 << 30
"""Bytes of addresses, of which libraries take more than half a gigabyte before there is any frame."""
UNDER_LIMIT = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, ({limit}, {limit}))
from sunfleck_tools.cli import main
sys.exit(main(sys.argv[1:]))
"""


def window(data: bytes, left: int, top: int, right: int, bottom: int, name: bytes = b"dataWindow") -> bytes:
    """The file with another window."""
    at = data.index(name + b"\0box2i\0") + len(name) + 7 + 4
    return data[:at] + struct.pack("<4i", left, top, right, bottom) + data[at + 16 :]


def table(data: bytes, offsets: Callable[[int], int]) -> bytes:
    """The file with other places of its chunks."""
    end = parse_header(data).end
    first = struct.unpack_from("<Q", data, end)[0]
    count = (first - end) // 8
    return data[:end] + struct.pack(f"<{count}Q", *map(offsets, range(count))) + data[first:]


def renamed_channel(data: bytes) -> bytes:
    """`albedo.B` becomes a name that is markup."""
    return data.replace(b"albedo.B", b"<img>&.B")


HOSTILE: dict[str, Callable[[bytes], bytes]] = {
    "10^9 pixels": lambda data: window(data, 0, 0, 31622, 31622),
    "10^18 pixels": lambda data: window(data, -(2**30), -(2**30), 2**30, 2**30),
    "as many pixels as there may be for the file": lambda data: window(data, 0, 0, 511, 1023),
    "the widest window": lambda data: window(data, -(2**31), 0, 2**31 - 1, 0),
    "a window inside out": lambda data: window(data, 10, 10, 0, 0),
    "a display window of 10^18 "
    "pixels": lambda data: window(data, -(2**30), -(2**30), 2**30, 2**30, b"displayWindow"),
    "a display window inside out": lambda data: window(data, 10, 10, 0, 0, b"displayWindow"),
    "chunks behind the end": lambda data: table(data, lambda index: 2**63 - 1),
    "all chunks at one place": lambda data: table(data, lambda index: len(data) - 600),
    "chunks in the header": lambda data: table(data, lambda index: 8),
    "cut off in its header": lambda data: data[:300],
    "cut off in its table": lambda data: data[: parse_header(data).end + 4],
    "cut off in its pixels": lambda data: data[: len(data) // 2],
    "a header without end": lambda data: data[:8] + b"name\0string\0" + struct.pack("<i", 5) + b"aaaaa" * 20000,
    "a name without end": lambda data: data[:8] + b"a" * 100000,
    "a channel with a name of markup": renamed_channel,
    "nothing": lambda data: b"",
    "not an EXR file": lambda data: bytes(range(256)) * 64,
}


@unittest.skipUnless(sys.platform == "linux", "limits of memory are Linux's")
class Hostile(unittest.TestCase):
    def test_all_of_them(self):
        whole = (DATA / "leaf.0006.exr").read_bytes()
        with tempfile.TemporaryDirectory() as folder:
            scratch = Path(folder)
            frames = good_sequence(scratch / "frames")
            for number, damage in enumerate(HOSTILE.values(), 13):
                frame_path(frames, number).write_bytes(damage(whole))
            page = scratch / "report.html"
            arguments = ["validate", frames, "--reference", frames, "--html", page, "--processes", "1"]
            done = subprocess.run(
                [sys.executable, "-c", UNDER_LIMIT.format(limit=MEMORY_LIMIT), *map(str, arguments)],
                capture_output=True, text=True, errors="replace", timeout=300,
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )  # fmt: skip
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertNotIn("Traceback", done.stderr + done.stdout)
            self.assertIn("13", done.stderr + done.stdout)
            self.assertIn("header claims", done.stderr + done.stdout)
            self.assertNotIn("<img>", page.read_text())
