"""JSON values with their paths, for errors with a place.

Invariant: any content of a file raises `SceneError` at most.
"""

import math
from collections.abc import Iterator
from typing import Any, NoReturn

from ..errors import SceneError


class Value:
    """JSON value with its file and its path."""

    def __init__(self, raw: Any, file: str, path: str = ""):
        self.raw, self.file, self.path = raw, file, path

    def fail(self, message: str) -> NoReturn:
        """Raises an error about this value."""
        raise SceneError(f"{self.file}: {self.path or 'the document'}: {message}")

    def member(self, name: str) -> "Value | None":
        """Member of an object; None if it is missing or null."""
        if not isinstance(self.raw, dict):
            self.fail("expected an object")
        raw = self.raw.get(name)
        return None if raw is None else Value(raw, self.file, f"{self.path}.{name}" if self.path else name)

    def need(self, name: str) -> "Value":
        """Member of an object, which must exist."""
        return self.member(name) or self.fail(f"has no `{name}`")

    def group(self, name: str) -> "Value":
        """Member of an object as an object, empty if it is missing."""
        return self.member(name) or Value({}, self.file, f"{self.path}.{name}" if self.path else name)

    @property
    def extras(self) -> "Value":
        """Custom properties; `extras` of any other type than an object have none."""
        found = self.group("extras")
        return found if isinstance(found.raw, dict) else Value({}, self.file, found.path)

    def extension(self, name: str) -> "Value | None":
        """An extension of glTF."""
        return self.group("extensions").member(name)

    def items(self, name: str) -> "list[Value]":
        """Member of an object as a list, empty if it is missing."""
        found = self.member(name)
        return [] if found is None else list(found.each())

    def each(self) -> "Iterator[Value]":
        """The items of a list."""
        if not isinstance(self.raw, list):
            self.fail("expected a list")
        for index, raw in enumerate(self.raw):
            yield Value(raw, self.file, f"{self.path}[{index}]")

    def number(self, least: float = -math.inf, most: float = math.inf) -> float:
        """A finite number within bounds."""
        raw = self.raw
        if (
            isinstance(raw, bool)
            or not isinstance(raw, (int, float))
            or not math.isfinite(raw)
            or not least <= raw <= most
        ):
            within = "" if math.isinf(least) and math.isinf(most) else f" from {least:g} to {most:g}"
            self.fail(f"expected a number{within}")
        return float(raw)

    def whole(self, least: int = 0, most: int = 2**53) -> int:
        """A whole number within bounds."""
        number = self.number(least, most)
        if number != int(number):
            self.fail("expected a whole number")
        return int(number)

    def index(self, of: list, what: str) -> int:
        """Integer that is a valid index into a list."""
        number = self.whole()
        if number >= len(of):
            self.fail(f"there is no {what} {number}, of {len(of)}")
        return number

    def item_of(self, items: "list[Value]", what: str) -> "Value":
        """Item of a list at this index."""
        return items[self.index(items, what)]

    def numbers(self, count: int) -> list[float]:
        """List of `count` finite numbers."""
        found = [value.number() for value in self.each()]
        if len(found) != count:
            self.fail(f"expected {count} numbers, found {len(found)}")
        return found

    def channels(self) -> list[float]:
        """Three numbers, or one for all three."""
        return self.numbers(3) if isinstance(self.raw, list) else [self.number()] * 3

    def text(self) -> str:
        """A string."""
        return self.raw if isinstance(self.raw, str) else self.fail("expected a text")

    def number_at(self, name: str, default: float, least: float = -math.inf, most: float = math.inf) -> float:
        """Number in an object."""
        found = self.member(name)
        return default if found is None else found.number(least, most)

    def numbers_at(self, name: str, *default: float) -> list[float]:
        """Numbers in an object, as many as the default has."""
        found = self.member(name)
        return list(default) if found is None else found.numbers(len(default))

    def text_at(self, name: str, default: str = "") -> str:
        """String in an object."""
        found = self.member(name)
        return default if found is None else found.text()
