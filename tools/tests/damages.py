"""Kinds of damage: each a function that damages a good sequence of twelve frames, and the checks
that have to find it.

`python -m tests.damages` (in tools/) prints them as a table.
"""

import os
import shutil
import struct
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from sunfleck_tools import Options, validate
from sunfleck_tools.exr.header import COMPRESSIONS, parse_header

from .files import Channels, add_attribute, flip, frame_path, good_sequence, rewrite, seal, write_frame
from .files import scene as moving_ball

VICTIM = 6
"""The frame that is damaged, with neighbours on both sides."""


@dataclass(frozen=True)
class Damage:
    """A way to spoil a sequence, and who must find it where."""

    what: str
    found_by: str
    frames: tuple[int | None, ...]
    make: Callable[[Path], None]


DAMAGES: list[Damage] = []


def damage(what: str, found_by: str, *frames: int | None):
    """Registers a function; without frames it is the victim that has to be named."""

    def register(make: Callable[[Path], None]) -> Callable[[Path], None]:
        DAMAGES.append(Damage(what, found_by, frames or (VICTIM,), make))
        return make

    return register


def set_value(channel: str, value: float) -> Callable[[Channels], None]:
    """One value, at column 5 of row 7."""

    def change(channels: Channels) -> None:
        channels[channel][7, 5] = value

    return change


def value_damage(what: str, found_by: str, channel: str, value: float) -> None:
    """Registers the damage of a single value, signed with a hash that fits."""
    damage(what, found_by)(lambda folder: rewrite(frame_path(folder, VICTIM), set_value(channel, value)))


value_damage("NaN in one value of G", "nan", "G", np.nan)
value_damage("NaN in one value of Position.X", "nan", "Position.X", np.nan)
value_damage("infinity in one value of R (half overflow, not clamped)", "infinity", "R", np.inf)
value_damage("minus infinity in one value of Normal.Y", "infinity", "Normal.Y", -np.inf)
value_damage("one value of R at 65504 (half overflow, clamped)", "half-overflow", "R", 65504)
value_damage("one negative value of B", "negative", "B", -0.01)
value_damage("one negative transmittance", "negative", "transmittance.R", -0.5)
value_damage("one negative alpha", "alpha-range", "A", -0.1)
value_damage("one alpha of 1.1", "alpha-range", "A", 1.1)
value_damage("transmittance of 1.5 in one value", "transmittance-range", "transmittance.G", 1.5)
value_damage("a depth of 0", "depth", "Z", 0)
value_damage("a depth behind the camera", "depth", "Z", -3)
value_damage("a normal of length 2", "normal-length", "Normal.X", 2)
value_damage("the mean of two leaves' numbers", "leaf-id", "leaf_id.X", 3.5)
value_damage("shafts brighter than the beauty", "beauty-sum", "shafts.G", 100)


@damage("the file is empty (a claimed placeholder)", "empty-file")
def empty(folder: Path) -> None:
    frame_path(folder, VICTIM).write_bytes(b"")


@damage("a text file with a frame's name", "header")
def text(folder: Path) -> None:
    frame_path(folder, VICTIM).write_text("not a picture")


@damage("the header claims 10^9 pixels", "size-claim")
def billion(folder: Path) -> None:
    path = frame_path(folder, VICTIM)
    data = path.read_bytes()
    at = data.index(b"dataWindow\0box2i\0") + len("dataWindow\0box2i\0") + 4
    path.write_bytes(data[:at] + struct.pack("<4i", 0, 0, 31622, 31622) + data[at + 16 :])


@damage("an attribute's size is 2^31 - 1", "header")
def huge_attribute(folder: Path) -> None:
    path = frame_path(folder, VICTIM)
    data = path.read_bytes()
    at = data.index(b"channels\0chlist\0") + len("channels\0chlist\0")
    path.write_bytes(data[:at] + struct.pack("<i", 2**31 - 1) + data[at + 4 :])


@damage("zeros in place of the second half", "chunks")
def second_half(folder: Path) -> None:
    path = frame_path(folder, VICTIM)
    data = path.read_bytes()
    half = len(data) // 2
    path.write_bytes(data[:half] + bytes(len(data) - half))


@damage("an offset of the chunk table is 0 (written incompletely)", "chunks")
def no_offset(folder: Path) -> None:
    path = frame_path(folder, VICTIM)
    data = path.read_bytes()
    end = parse_header(data).end
    path.write_bytes(data[:end] + bytes(8) + data[end + 8 :])


@damage("zeros inside a chunk of PIZ, which decode to anything", "chunks")
def zeros_in_piz(folder: Path) -> None:
    path = frame_path(folder, VICTIM)
    rewrite(path, compression=4, texts={"pixelHash": None}, sign=False)
    data = path.read_bytes()
    at = len(data) - 400
    path.write_bytes(data[:at] + bytes(64) + data[at + 64 :])


COMPRESSED = {
    0: "pixel-hash", 1: "pixel-hash", 2: "decode", 3: "decode", 4: "pixel-hash", 5: "decode", 6: "pixel-hash",
    7: "pixel-hash", 8: "decode", 9: "decode", 10: "pixel-hash", 11: "pixel-hash", 13: "pixel-hash",
}  # fmt: skip
"""Who finds a flipped byte in which compression: the decoder, where there is a checksum; the hash,
where there is none."""


@damage("two frames swapped", "image-counter", VICTIM, VICTIM + 1)
def swapped(folder: Path) -> None:
    one, other, aside = frame_path(folder, VICTIM), frame_path(folder, VICTIM + 1), folder / "aside"
    one.rename(aside)
    other.rename(one)
    aside.rename(other)


@damage("a frame copied over the next one", "image-counter", VICTIM + 1)
def copied(folder: Path) -> None:
    shutil.copy(frame_path(folder, VICTIM), frame_path(folder, VICTIM + 1))


@damage("a frame stuck: pixels of the one before under its own number", "stuck", VICTIM)
def stuck(folder: Path) -> None:
    shutil.copy(frame_path(folder, VICTIM - 1), frame_path(folder, VICTIM))
    rewrite(frame_path(folder, VICTIM), counter=VICTIM)


def of_another_renderer(folder: Path) -> None:
    """Frames in which something moves, and nothing but the name says the number."""
    for number in range(1, 13):
        write_frame(frame_path(folder, number), moving_ball(number))


@damage("two frames swapped that say no number", "order", VICTIM, VICTIM + 1)
def swapped_without_numbers(folder: Path) -> None:
    of_another_renderer(folder)
    swapped(folder)


@damage("the last frame of one of two sequences is missing", "shorter-sequence", None)
def shorter(folder: Path) -> None:
    for number in range(1, 12):
        shutil.copy(frame_path(folder, number), frame_path(folder, number, "depth"))


@damage("a frame is missing", "missing-frame")
def missing(folder: Path) -> None:
    frame_path(folder, VICTIM).unlink()


@damage("a frame has another name", "foreign-file", None)
def renamed(folder: Path) -> None:
    frame_path(folder, VICTIM).rename(folder / "beech.0006.exr")


@damage("a number without its zeros", "mixed-padding")
def padding(folder: Path) -> None:
    frame_path(folder, VICTIM).rename(folder / "leaf.6.exr")


@damage("a frame twice, with and without zeros", "duplicate-frame")
def twice(folder: Path) -> None:
    shutil.copy(frame_path(folder, VICTIM), folder / "leaf.6.exr")


@damage("what a killed render left", "temporary-file", None)
def temporary(folder: Path) -> None:
    (folder / ".leaf.0006.exr.x1y2z3.sunfleck-part").write_bytes(b"half of it")


@damage("frames numbered one too high", "image-counter", *range(2, 14))
def off_by_one(folder: Path) -> None:
    for number in range(12, 0, -1):
        os.rename(frame_path(folder, number), frame_path(folder, number + 1))


@damage("one frame of 25 frames a second", "frame-rate")
def other_rate(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), fps=Fraction(25))


@damage("one frame without a frame rate", "frame-rate")
def no_rate(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), fps=None)


def with_time_codes(folder: Path, code_of: Callable[[int], int]) -> None:
    """Gives every frame a time code of minutes 0, seconds 0."""
    for number in range(1, 13):
        tens, ones = divmod(code_of(number), 10)
        add_attribute(
            frame_path(folder, number), "timeCode", "timecode", struct.pack("<II", tens << 4 | ones, 0)
        )


@damage("a time code that is two frames ahead", "time-code")
def time_code(folder: Path) -> None:
    with_time_codes(folder, lambda number: number + 2 * (number == VICTIM))


@damage("one frame of another size", "structure")
def size(folder: Path) -> None:
    rewrite(
        frame_path(folder, VICTIM), lambda channels: {name: values[:-2] for name, values in channels.items()}
    )


@damage("one frame lacks a pass", "structure")
def no_pass(folder: Path) -> None:
    rewrite(
        frame_path(folder, VICTIM),
        lambda c: {name: v for name, v in c.items() if not name.startswith("albedo")},
    )


@damage("one frame has floats where the others have halves", "structure")
def floats(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), lambda c: {**c, "R": c["R"].astype(np.float32)})


@damage("one frame has another compression", "structure")
def compression(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), compression=4)


@damage("one frame of other chromaticities", "structure")
def chromaticities(folder: Path) -> None:
    ap0 = struct.pack("<8f", 0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
    add_attribute(frame_path(folder, VICTIM), "chromaticities", "chromaticities", ap0)


@damage("one frame of another colour space by its name", "structure")
def color_id(folder: Path) -> None:
    add_attribute(frame_path(folder, VICTIM), "colorInteropID", "string", b"lin_ap1_scene")


@damage("a name of a colour space that disagrees with the chromaticities", "colour-space")
def color_conflict(folder: Path) -> None:
    ap0 = struct.pack("<8f", 0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
    add_attribute(frame_path(folder, VICTIM), "chromaticities", "chromaticities", ap0)
    add_attribute(frame_path(folder, VICTIM), "colorInteropID", "string", b"lin_rec709_scene")


@damage("ids of Cryptomatte in half precision", "half-id")
def half_ids(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), lambda c: {**c, "CryptoObject00.R": c["R"].astype(np.float16)})


@damage("one frame of another pixel aspect", "structure")
def pixel_aspect(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), extra={"pixelAspectRatio": 2.0})


@damage("one frame of another version", "mixed-version")
def version(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), texts={"version": "0.0.9"})


@damage("one frame of an older state of the scene", "mixed-scene")
def scene(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), texts={"sceneHash": "0" * 64})


@damage("one frame with other settings", "mixed-settings")
def settings(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), texts={"settingsHash": "0" * 64})


@damage("the last of the scene's own frames is missing", "ends-early", None)
def last_missing(folder: Path) -> None:
    numbers = [int(path.suffixes[0][1:]) for path in folder.glob("leaf.*.exr")]
    for number in numbers:
        rewrite(frame_path(folder, number), texts={"sequenceFrames": f"{min(numbers)}-{max(numbers)}"})
    frame_path(folder, max(numbers)).unlink()


@damage("one frame with another seed", "mixed-seed")
def seed(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), texts={"seed": "7"})


@damage("one frame saved by another program, its hash lost", "unsigned")
def hash_lost(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), texts={"pixelHash": None}, sign=False)


@damage("one value changed without a new hash", "pixel-hash")
def changed(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), set_value("G", 0.123), sign=False)


def seal_all(folder: Path) -> Path:
    """All frames with hashes of their files, and the victim's path."""
    for path in folder.glob("*.exr"):
        seal(path)
    return frame_path(folder, VICTIM)


@damage("one bit of a header flipped", "file-hash")
def header_bit(folder: Path) -> None:
    path = seal_all(folder)
    # The width of the screen window, which no other check looks at.
    flip(
        path,
        path.read_bytes().index(b"screenWindowWidth\0float\0") + len(b"screenWindowWidth\0float\0") + 4,
        1,
    )


@damage("a byte added to the end of a file", "file-hash")
def byte_added(folder: Path) -> None:
    path = seal_all(folder)
    path.write_bytes(path.read_bytes() + b"\0")


@damage("one bit flipped in the name of the file's hash", "unsigned")
def hash_renamed(folder: Path) -> None:
    path = seal_all(folder)
    flip(path, path.read_bytes().index(b"sunfleck:fileHash"), 1)


@damage("one firefly", "firefly")
def firefly(folder: Path) -> None:
    def spike(channels: Channels) -> None:
        for letter in "RGB":
            channels[letter][7, 5] = 500

    rewrite(frame_path(folder, VICTIM), spike)


@damage("one black frame", "black")
def black(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), lambda channels: scaled(channels, 0))


@damage("the last two frames black, without a fade", "black", 11, 12)
def black_end(folder: Path) -> None:
    for number in (11, 12):
        rewrite(frame_path(folder, number), lambda channels: scaled(channels, 0))


@damage("every frame black", "all-black", None)
def all_black(folder: Path) -> None:
    for number in range(1, 13):
        rewrite(frame_path(folder, number), lambda channels: scaled(channels, 0))


@damage("one frame of a single colour", "constant")
def constant(folder: Path) -> None:
    def even(channels: Channels) -> None:
        for letter in "RGB":
            channels[letter][:] = channels["shafts." + letter].max()

    rewrite(frame_path(folder, VICTIM), even)


def block(channels: Channels, rows: slice, columns: slice) -> None:
    """Sets a part of the picture to zero."""
    for letter in "RGB":
        channels[letter][rows, columns] = channels["shafts." + letter][rows, columns] = 0


@damage("a bucket of 16 x 9 pixels was lost", "black-block")
def lost_bucket(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), lambda channels: block(channels, slice(9, 18), slice(16, 32)))


@damage("a block of 10 rows was lost", "black-block")
def lost_rows(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), lambda channels: block(channels, slice(0, 10), slice(0, 32)))


@damage("one frame half empty: its file is far smaller", "file-size")
def half_empty(folder: Path) -> None:
    def clear(channels: Channels) -> None:
        for name, values in channels.items():
            values[3:] = 1e10 if name == "Z" else 0

    rewrite(frame_path(folder, VICTIM), clear)


def scaled(channels: Channels, factor: float) -> None:
    """Light of beauty and shafts times a factor."""
    for name in ("R", "G", "B", "shafts.R", "shafts.G", "shafts.B"):
        channels[name][:] = channels[name].astype(np.float32) * factor


@damage("one frame half as bright again", "pop")
def pop(folder: Path) -> None:
    rewrite(frame_path(folder, VICTIM), lambda channels: scaled(channels, 1.5))


@damage("every second frame brighter by 0.08", "flicker", 1)
def flicker(folder: Path) -> None:
    for number in range(2, 13, 2):
        rewrite(frame_path(folder, number), lambda channels: scaled(channels, 1.08))


def with_pass(folder: Path, channel: str, value: float) -> None:
    """Adds a pass of zeros to all frames, with one odd value in the victim's."""
    for number in range(1, 13):

        def add(channels: Channels, number: int = number) -> Channels:
            added = np.zeros_like(channels["Z"])
            added[7, 5] = value if number == VICTIM else 0
            return {**channels, channel: added}

        rewrite(frame_path(folder, number), add)


@damage("motion of a million pixels", "motion")
def far_motion(folder: Path) -> None:
    with_pass(folder, "motion.X", 1e6)


@damage("motion that is NaN", "motion")
def nan_motion(folder: Path) -> None:
    with_pass(folder, "motion.X", np.nan)


def _flipped(kind: int) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        path = frame_path(folder, VICTIM)
        rewrite(path, compression=kind)
        flip(path, path.stat().st_size * 2 // 3, 0x55)

    return make


for _kind, _finder in COMPRESSED.items():
    damage(f"a byte flipped, compression {COMPRESSIONS[_kind]}", _finder)(_flipped(_kind))


def main() -> None:
    """Prints the table of checks and damages."""
    print("| damage | check | found |\n|---|---|---|")
    for entry in DAMAGES:
        with tempfile.TemporaryDirectory() as scratch:
            folder = good_sequence(Path(scratch))
            entry.make(folder)
            report = validate(folder, Options(processes=0))
        found = {finding.frame for finding in report.findings if finding.check == entry.found_by}
        answer = "yes" if set(entry.frames) <= found else "**no**"
        print(f"| {entry.what} | `{entry.found_by}` | {answer} |")


if __name__ == "__main__":
    main()
