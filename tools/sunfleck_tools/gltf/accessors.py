"""Accessors to arrays of numbers (specification, 3.6.2)."""

import numpy as np

from .container import Container
from .values import Value

COMPONENTS = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
MOST_ZEROS = 2**24
"""Maximum numbers of an accessor without a buffer."""


class Accessors:
    """The accessors of a file, each read once."""

    def __init__(self, container: Container):
        self.container = container
        self.described = container.document.items("accessors")
        self._read: dict[int, np.ndarray] = {}

    def floats(self, index: Value, width: int) -> np.ndarray:
        """Rows of `width` finite numbers; integers are normalized if the accessor says so."""
        array, normalised = self._array(index, width)
        if normalised and array.dtype.kind in "iu":
            array = np.maximum(array / np.float64(np.iinfo(array.dtype).max), -1.0)
        array = np.asarray(array, np.float32)
        if not np.isfinite(array).all():
            index.fail("holds numbers that are not finite")
        return array

    def integers(self, index: Value, below: int, what: str, width: int = 1) -> np.ndarray:
        """Rows of integers below `below`."""
        array, _ = self._array(index, width)
        if array.dtype.kind != "u" or (array.size and int(array.max()) >= below):
            index.fail(f"expected numbers of {what}, below {below}")
        return array.astype(np.int64)

    def _array(self, index: Value, width: int) -> tuple[np.ndarray, bool]:
        number = index.index(self.described, "accessor")
        described = self.described[number]
        if WIDTHS.get(described.text_at("type")) != width:
            index.fail(f"expected rows of {width}, found `{described.text_at('type')}`")
        if number not in self._read:
            self._read[number] = self._dense(described, width)
        normalised = described.member("normalized")
        return self._read[number], normalised is not None and normalised.raw is True

    def _dense(self, described: Value, width: int) -> np.ndarray:
        count = described.need("count").whole()
        kind = self._kind(described)
        view = described.member("bufferView")
        if view is not None:
            array = self._rows(described, view, kind, count, width)
        elif count * width <= MOST_ZEROS:
            array = np.zeros((count, width), kind)
        else:
            described.fail(f"claims {count} values and has no bytes")
        if (sparse := described.member("sparse")) is not None:
            array = array.copy()
            changed = sparse.need("count").whole(most=count)
            where, values = sparse.need("indices"), sparse.need("values")
            rows = self._rows(where, where.need("bufferView"), self._kind(where), changed, 1)[:, 0]
            if rows.size and (rows.dtype.kind != "u" or int(rows.max()) >= count):
                where.fail(f"expected places below {count}")
            array[rows] = self._rows(values, values.need("bufferView"), kind, changed, width)
        return array

    def _kind(self, described: Value) -> np.dtype:
        number = described.need("componentType")
        if number.whole() not in COMPONENTS:
            number.fail("is no component type of glTF")
        return np.dtype(COMPONENTS[number.whole()]).newbyteorder("<")

    def _rows(self, described: Value, view: Value, kind: np.dtype, count: int, width: int) -> np.ndarray:
        data, start, length, stride = self.container.view(view)
        first = int(described.number_at("byteOffset", 0, 0))
        row = kind.itemsize * width
        stride = stride or row
        if stride < row or (count > 0 and first + (count - 1) * stride + row > length):
            described.fail(f"reads {count} rows of {stride} bytes from byte {first} of a view of {length}")
        if count == 0:
            return np.zeros((0, width), kind)
        return np.ndarray((count, width), kind, data, start + first, (stride, kind.itemsize))
