"""Tools around the frames that sunfleck renders.

`validate(target, options)` checks a sequence of EXR frames, as `sunfleck-tools validate` does on the
command line. `sunfleck_tools.usd` writes and reads USD stages.
"""

from importlib import import_module

__version__ = "0.1.0"
MODULES = {
    "Options": "options", "Report": "validation", "SceneError": "errors", "SequenceError": "sequence", "ToolError": "errors",
    "validate": "validation",
}  # fmt: skip
__all__ = ["Options", "Report", "SceneError", "SequenceError", "ToolError", "validate", "__version__"]


def __getattr__(name: str) -> object:
    """Imports exported names on first use: libraries load slowly, and signals have to be handled before
    that."""
    if name not in MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{MODULES[name]}", __name__), name)
