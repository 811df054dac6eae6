"""Rendering by the program. In go an input, frames and settings, out come frames.

Invariant: without `out` nothing is left on the disk.
"""

import os
import tempfile
from collections.abc import Generator, Iterable, Iterator
from contextlib import closing, contextmanager

from .flags import as_flags, frame_number, joined, path_text
from .frame import Frame, read
from .process import events
from .progress import Event, EventBar, Progress, watcher

Path = str | os.PathLike[str]


def render(
    scene: Path, frame: int = 1, *, out: Path | None = None, progress: Progress | bool | None = None, **settings: object
) -> Frame:
    """One frame of an input: a sequence or scene (`.ron`), glTF or OBJ.

    `out` keeps the file, as `--out` does. `progress` is a function that gets each event of `--progress
    jsonl`; the default is a bar, if standard error is a terminal; `False` is silence. `settings` are all
    other flags of `sunfleck render`, `_` for `-`: `size=(960, 540)` or `"50%"`, `passes=["depth", "normal"]`,
    `tolerance=0.01`, `camera="main"`, `strict=True`.

    Raises a `SunfleckError`: `UsageError`, `SceneError`, `FileError`, `FrameError`, `Stopped`, or
    `ProgramError`.
    """
    with closing(_rendered(scene, frame_number(frame), as_flags(settings), out, progress)) as frames:
        (found,) = frames
    return found


def render_frames(
    scene: Path,
    frames: str | int | Iterable[int] = "all",
    *,
    out: Path | None = None,
    progress: Progress | bool | None = None,
    **settings: object,
) -> Iterator[Frame]:
    """Frames in the order of the list, each as soon as it is written, while the program renders the next;
    otherwise as `render`.

    `frames` is a list in the command line's form (`"1-48x2"`), or of numbers. The program starts with the
    first request of a frame, and ends with the iterator: `close()` cancels the rest.
    """
    return _rendered(scene, frames, as_flags(settings), out, progress)


def _rendered(
    scene: Path, frames: str | int | Iterable[int], flags: list[str], out: Path | None, progress: Progress | bool | None
) -> Generator[Frame, None, None]:
    """Checks arguments at once; the iterator does the rest."""
    folder = None if out is None else path_text("out", out)
    command = ["render", f"--frames={joined('frames', frames)}", "--progress=jsonl", *flags]
    return _frames(command, path_text("scene", scene), folder, watcher(progress))


def _frames(command: list[str], scene: str, out: str | None, watch: Progress) -> Generator[Frame, None, None]:
    try:
        with _folder(out) as folder:
            with closing(events([*command, f"--out={folder}", "--", scene])) as told:
                for event in told:
                    watch(event)
                    if event["event"] == "frame_written":
                        yield _taken(event, keep=out is not None)
    finally:
        if isinstance(watch, EventBar):
            watch.close()


@contextmanager
def _folder(out: str | None) -> Iterator[str]:
    """Folder of frames: the given one, or a temporary one."""
    if out is not None:
        yield out
        return
    with tempfile.TemporaryDirectory(prefix="sunfleck-") as folder:
        yield os.path.join(folder, "")


def _taken(event: Event, keep: bool) -> Frame:
    path = event["path"]
    frame = read(path)
    frame.number = event["frame"]
    if not keep:
        os.unlink(path)
    return frame
