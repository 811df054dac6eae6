"""JSON with the path that leads to it, so that whatever is wrong is said with its place.

Invariant: nothing that a file holds raises anything but `SceneError`.
"""

import math
from collections.abc import Iterator
from typing import Any, NoReturn

from ..errors import SceneError


class Value:
    """A JSON value, the file that it is from and its path there."""

    def __init__(self, raw: Any, file: str, path: str = ""):
        self.raw, self.file, self.path = raw, file, path

    def fail(self, message: str) -> NoReturn:
        """Refuses the file for this value."""
        raise SceneError(f"{self.file}: {self.path or 'the document'}: {message}")

    def member(self, name: str) -> "Value | None":
        """What an object holds under a name; None too if it is null."""
        if not isinstance(self.raw, dict):
            self.fail("expected an object")
        raw = self.raw.get(name)
        return None if raw is None else Value(raw, self.file, f"{self.path}.{name}" if self.path else name)

    def need(self, name: str) -> "Value":
        """The same, refused if it is missing."""
        return self.member(name) or self.fail(f"has no `{name}`")

    def group(self, name: str) -> "Value":
        """An object, empty if it is missing."""
        return self.member(name) or Value({}, self.file, f"{self.path}.{name}" if self.path else name)

    def extension(self, name: str) -> "Value | None":
        """An extension of glTF."""
        return self.group("extensions").member(name)

    def items(self, name: str) -> "list[Value]":
        """A list, empty if it is missing."""
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
        """A whole number that counts into a list."""
        number = self.whole()
        if number >= len(of):
            self.fail(f"there is no {what} {number}, of {len(of)}")
        return number

    def item_of(self, items: "list[Value]", what: str) -> "Value":
        """The item of a list that this counts to."""
        return items[self.index(items, what)]

    def numbers(self, count: int) -> list[float]:
        """So many finite numbers."""
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
        """A number of an object."""
        found = self.member(name)
        return default if found is None else found.number(least, most)

    def numbers_at(self, name: str, *default: float) -> list[float]:
        """Numbers of an object, as many as the default has."""
        found = self.member(name)
        return list(default) if found is None else found.numbers(len(default))

    def text_at(self, name: str, default: str = "") -> str:
        """A string of an object."""
        found = self.member(name)
        return default if found is None else found.text()
