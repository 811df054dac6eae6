"""What a call can end with, a class for each exit code of the program.

Invariant: the text of an error is the program's own, with place, expectation and remedy.
"""

import signal

from .diagnostic import Diagnostic, diagnostics

STOPPED = {130, 143}
HELP = "`sunfleck render --help` has every setting and what it takes, with - for _"


class SunfleckWarning(UserWarning):
    """What a scene asks for and does not get, and frames on which next to nothing is seen."""


class SunfleckError(Exception):
    """Why there is no frame. `diagnostics` has the parts of what was said, warnings before it included."""

    def __init__(self, message: str, exit_code: int | None = None, said: tuple[Diagnostic, ...] = ()):
        super().__init__(message)
        self.exit_code = exit_code
        self.diagnostics = said

    @property
    def place(self) -> str:
        """The file, and the place in it, of the first error; empty where there is none."""
        return self._first.place

    @property
    def remedy(self) -> str:
        """What helps, in the words of the first error."""
        return self._first.remedy

    @property
    def _first(self) -> Diagnostic:
        found = (diagnostic for diagnostic in self.diagnostics if diagnostic.severity == "error")
        return next(found, Diagnostic("error", str(self)))


class ProgramError(SunfleckError):
    """There is no program, it is of another version, or it died."""


class UsageError(SunfleckError):
    """A setting cannot be used, or does not suit the input (exit code 2)."""

    @property
    def remedy(self) -> str:
        said = super().remedy
        # What the parser of command lines says for want of a better word serves nobody here.
        return HELP if not said or said.startswith("to pass '") else said


class WrongType(UsageError, TypeError):
    """An argument has a type, or a value, that it cannot have; nothing was started."""

    def __init__(self, found: str, remedy: str):
        text = f"error: {found}\n  remedy: {remedy}"
        super().__init__(text, 2, (Diagnostic("error", found, remedy=remedy, text=text),))

    def __reduce__(self) -> tuple[type["WrongType"], tuple[str, str]]:
        # Of an exception that cannot be made anew a pool of processes waits for ever.
        return WrongType, (self.diagnostics[0].message, self.remedy)


class SceneError(SunfleckError):
    """The input can be read but not used (3)."""


class FileError(SunfleckError):
    """A file cannot be read or written (4)."""


class FrameError(SunfleckError):
    """A frame holds NaN or took too long, and was not written (5)."""


class Stopped(SunfleckError):
    """Somebody ended the program by a signal (130, 143)."""


KINDS = {2: UsageError, 3: SceneError, 4: FileError, 5: FrameError, **dict.fromkeys(STOPPED, Stopped)}


def error_of(exit_code: int, said: str) -> SunfleckError:
    """What the program ended with, as subprocess has exit codes: below 0 is the signal that killed it."""
    found = diagnostics(said)
    if exit_code in KINDS:
        errors = [diagnostic.text for diagnostic in found if diagnostic.severity == "error"]
        return KINDS[exit_code]("\n".join(errors) or said.strip() or f"exit code {exit_code}", exit_code, found)
    if exit_code < 0:
        name = signal.Signals(-exit_code).name if -exit_code in set(signal.Signals) else f"signal {-exit_code}"
        words = f"{name} ended the program, as the system does where memory lacks: choose a smaller size, or fewer threads"
        return ProgramError(words, exit_code, found)
    words = f"the program ended with exit code {exit_code}, which none of its errors has: {said.strip() or 'it said nothing'}"
    return ProgramError(words, exit_code, found)
