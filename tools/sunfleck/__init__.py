"""Falling leaves in the light of sun and lamps, as numpy arrays.

    import sunfleck
    frame = sunfleck.render("shot.ron", frame=12, size=(960, 540), passes=["depth"])
    frame.beauty          # float32, 540 x 960 x 4: linear Rec. 709, premultiplied alpha
    frame.passes["depth"].unit, frame.metadata["sunfleck:sceneHash"]

The program `sunfleck` renders, in a process of its own. This package starts it, tells how far it is, and
reads what it wrote. Invariant: whatever ends a call (an error, Ctrl-C, an iterator that is dropped) ends the
program too. Only whole frames are left, where `out` wanted them.
"""

from importlib import import_module
from importlib.util import find_spec

__version__ = "0.1.0"
MODULES = {
    "Diagnostic": "diagnostic", "FileError": "errors", "Frame": "frame", "FrameError": "errors", "Pass": "frame",
    "ProgramError": "errors", "SceneError": "errors", "Stopped": "errors", "SunfleckError": "errors", "SunfleckWarning": "errors",
    "UsageError": "errors", "WrongType": "errors", "inspect": "inspection", "read": "frame", "render": "rendering", "render_frames": "rendering",
}  # fmt: skip
__all__ = [*MODULES, "__version__"]

for _package in ("numpy", "OpenEXR"):
    if find_spec(_package) is None:
        raise ModuleNotFoundError(
            f"`import sunfleck` reads frames with numpy and OpenEXR, and {_package} is not installed: "
            "pip install numpy OpenEXR (the program `sunfleck` needs neither)",
            name=_package,
        )


def __getattr__(name: str) -> object:
    """What is exported, once it is asked for: numpy takes its time, in which a signal has to be heard already."""
    if name not in MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
