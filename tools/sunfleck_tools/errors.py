"""Errors of commands, with messages for the caller."""


class ToolError(Exception):
    """The command cannot be carried out; `is_usage` is true for a wrong command line, and false for a
    failure such as that of a disk."""

    def __init__(self, message: str, is_usage: bool = True):
        super().__init__(message)
        self.is_usage = is_usage


class Terminated(BaseException):
    """The system asks the program to terminate."""


class SceneError(Exception):
    """A scene cannot be read, or not be written as requested. The message has the place, the finding and
    the remedy, if there is one."""
