"""What a command cannot do, in words for whoever called it."""


class ToolError(Exception):
    """Nothing can be done with what was given; `is_usage` tells a wrong command from a disk that fails."""

    def __init__(self, message: str, is_usage: bool = True):
        super().__init__(message)
        self.is_usage = is_usage


class Terminated(BaseException):
    """The system asks the program to end."""


class SceneError(Exception):
    """A scene cannot be read, or not be written as asked; says where, what, and where there
    is one the remedy."""
