"""Errors of calls, a class for each exit code of the program.

Invariant: the text of an error is the program's own, with place, expectation and remedy.
"""

import signal

from .diagnostic import Diagnostic, diagnostics

STOPPED = {130, 143}
HELP = "`sunfleck render --help` has every setting and what it takes, with - for _"


class SunfleckWarning(UserWarning):
    """A request of the scene that is not honoured, or a frame that looks black."""


class SunfleckError(Exception):
    """Reason why there is no frame. `diagnostics` has the parts of the message, earlier warnings included."""

    def __init__(self, message: str, exit_code: int | None = None, said: tuple[Diagnostic, ...] = ()):
        super().__init__(message)
        self.exit_code = exit_code
        self.diagnostics = said

    @property
    def place(self) -> str:
        """File and place of the first error; empty without one."""
        return self._first.place

    @property
    def remedy(self) -> str:
        """Remedy of the first error."""
        return self._first.remedy

    @property
    def _first(self) -> Diagnostic:
        found = (diagnostic for diagnostic in self.diagnostics if diagnostic.severity == "error")
        return next(found, Diagnostic("error", str(self)))


class ProgramError(SunfleckError):
    """The program is missing, of another version, or crashed."""


class UsageError(SunfleckError):
    """A setting is invalid, or does not suit the input (exit code 2)."""

    @property
    def remedy(self) -> str:
        said = super().remedy
        # The command line's generic hint does not apply here.
        return HELP if not said or said.startswith("to pass '") else said


class WrongType(UsageError, TypeError):
    """An argument has an invalid type or value; nothing was started."""

    def __init__(self, found: str, remedy: str):
        text = f"error: {found}\n  remedy: {remedy}"
        super().__init__(text, 2, (Diagnostic("error", found, remedy=remedy, text=text),))

    def __reduce__(self) -> tuple[type["WrongType"], tuple[str, str]]:
        # A pool of processes waits forever for an exception that cannot be unpickled.
        return WrongType, (self.diagnostics[0].message, self.remedy)


class SceneError(SunfleckError):
    """The input can be read but is invalid (3)."""


class FileError(SunfleckError):
    """A file cannot be read or written (4)."""


class FrameError(SunfleckError):
    """A frame holds NaN or exceeded the time limit, and was not written (5)."""


class Stopped(SunfleckError):
    """A signal ended the program (130, 143)."""


KINDS = {2: UsageError, 3: SceneError, 4: FileError, 5: FrameError, **dict.fromkeys(STOPPED, Stopped)}


def error_of(exit_code: int, said: str) -> SunfleckError:
    """Error for an exit code as of subprocess: below 0 is the signal that killed the program."""
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
