"""Alias of the add-on's package: as an extension, Blender calls it `bl_ext.REPOSITORY.sunfleck`.

Invariant: `import sunfleck.command` gives the add-on's own modules, each loaded once; an existing package
of that name stays.
"""

import sys

SHORT = "sunfleck"


def register() -> None:
    if __package__ == SHORT or SHORT in sys.modules:
        return
    for name, module in list(sys.modules.items()):
        if name == __package__ or name.startswith(f"{__package__}."):
            sys.modules[SHORT + name[len(__package__) :]] = module


def unregister() -> None:
    if __package__ == SHORT or sys.modules.get(SHORT) is not sys.modules[__package__]:
        return
    for name in [name for name in sys.modules if name == SHORT or name.startswith(f"{SHORT}.")]:
        del sys.modules[name]
