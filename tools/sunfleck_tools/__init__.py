"""Tools around the frames that sunfleck renders.

`validate(target, options)` says of a sequence of EXR frames whether it can be trusted;
`sunfleck-tools validate` is the same on the command line. `sunfleck_tools.usd` has what writes
and reads USD stages.
"""

from importlib import import_module

__version__ = "0.1.0"
MODULES = {
    "Options": "options", "Report": "validation", "SceneError": "errors", "SequenceError": "sequence", "ToolError": "errors",
    "validate": "validation",
}  # fmt: skip
__all__ = ["Options", "Report", "SceneError", "SequenceError", "ToolError", "validate", "__version__"]


def __getattr__(name: str) -> object:
    """What is exported, once it is asked for: libraries take their time, in which a signal has to
    be heard already."""
    if name not in MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{MODULES[name]}", __name__), name)
