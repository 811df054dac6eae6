"""Nodes of a glTF file under construction. In go transforms and properties, out come nodes. Invariant:
each has a unique name."""

import numpy as np

from ...gltf.writer import GlbWriter
from ..samples import thinned
from .losses import Losses, TooMuch
from .places import parts, sheared, turn_of
from .source import Source

MOST_NODES = 2_000_000
MOST_SAMPLES = 30_000_000
RESTS = {"translation": [0.0] * 3, "rotation": [0.0, 0.0, 0.0, 1.0], "scale": [1.0] * 3}
UNTURNED = np.eye(3)


class Nodes:
    """Adds nodes to a file."""

    def __init__(self, writer: GlbWriter, source: Source, lost: Losses):
        self.writer, self.source, self.lost = writer, source, lost
        self.roots: list[int] = []
        self._names: dict[str, int] = {}
        self._parents: dict[int, int] = {}
        self._samples = 0

    def add(self, name: str, parent: int | None) -> int:
        """Adds a node below another, or at the top."""
        if len(self.writer.document.get("nodes", ())) >= MOST_NODES:
            raise TooMuch(f"{self.source.path}: is more than {MOST_NODES} nodes")
        number = self.writer.add("nodes", {"name": self._unused(name)})
        if parent is None:
            self.roots.append(number)
        else:
            self.of(parent).setdefault("children", []).append(number)
            self._parents[number] = parent
        return number

    def of(self, number: int) -> dict:
        """A node itself."""
        return self.writer.document["nodes"][number]

    def linear(self, number: int) -> np.ndarray:
        """Linear part of the transform to the world at rest, metres."""
        found = np.eye(3)
        at: int | None = number
        while at is not None:
            node = self.of(at)
            turn = turn_of(node.get("rotation", [0.0, 0.0, 0.0, 1.0]))
            found = turn @ np.diag(node.get("scale", [1.0] * 3)) @ found
            at = self._parents.get(at)
        return found

    def _unused(self, name: str) -> str:
        """Unique name, as animated values refer to nodes by name."""
        found = name
        while found in self._names:
            self._names[name] += 1
            found = f"{name}.{self._names[name]:03d}"
        self._names[found] = 0
        return found

    def place(self, node: int, codes: np.ndarray, matrices: np.ndarray) -> int:
        """Sets a node's transform from matrices; children belong to the returned node."""
        if len(codes) == 1 and (matrices[0, :3, :3] == UNTURNED).all():
            self._move(node, codes, {"translation": matrices[:, :3, 3]})
            return node
        translations, turns, scales, is_all = parts(matrices)
        if is_all:
            self._move(node, codes, {"translation": translations, "rotation": turns, "scale": scales})
            return node
        if len(codes) > 1:
            what = "shears as it moves: it is right at samples, less so between them"
            self.lost.add("usd-shear", self.of(node)["name"], what)
        outer, scales, inner = sheared(matrices)
        self._move(node, codes, {"translation": translations, "rotation": outer, "scale": scales})
        last = self.add(f"{self.of(node)['name']} (sheared)", node)
        self._move(last, codes, {"rotation": inner})
        return last

    def move(
        self, node: int, codes: np.ndarray, translations: np.ndarray, turns: np.ndarray, scales: np.ndarray
    ) -> None:
        """Sets a node's transform from parts."""
        self._move(node, codes, {"translation": translations, "rotation": turns, "scale": scales})

    def _move(self, node: int, codes: np.ndarray, rows: dict[str, np.ndarray]) -> None:
        self._samples += len(codes)
        if self._samples > MOST_SAMPLES:
            raise TooMuch(f"{self.source.path}: has more than {MOST_SAMPLES} samples of places")
        for path, values in rows.items():
            # Differences by rounding are no motion.
            values = np.asarray(values, np.float32)
            if len(values) > 1 and np.ptp(values, axis=0).max() < 1e-7 * max(1.0, np.abs(values).max()):
                values = values[:1]
            first = values[0].tolist()
            if any(abs(value - rest) > 1e-9 for value, rest in zip(first, RESTS[path])):
                self.of(node)[path] = first
            if len(values) > 1:
                kept, values = thinned(codes, values)
                self.writer.animate(node, path, self.source.seconds(kept), values)

    def show(self, node: int, codes: np.ndarray, shown: np.ndarray) -> None:
        """Sets the visibility of a node and its descendants from each code on."""
        if shown.all():
            return
        if shown.any():
            self.carry(node, "sunfleck_node.visible", codes, shown[:, None].astype(float), steps=True)
        else:
            self.writer.extensions.add("KHR_node_visibility")
            self.of(node).setdefault("extensions", {})["KHR_node_visibility"] = {"visible": False}

    def extra(self, node: int, name: str, value: object) -> None:
        """Sets a custom property."""
        self.of(node).setdefault("extras", {})[name] = value

    def carry(
        self, owner: int | None, field: str, codes: np.ndarray, rows: np.ndarray, steps: bool = False
    ) -> None:
        """Adds a node that carries an animated value of a node, or of the scene."""
        target = f"{'scene' if owner is None else self.of(owner)['name']}.{field}"
        node = self.add(f"ctl_{target}", None)
        wide = np.zeros((len(rows), 3))
        wide[:, : rows.shape[1]] = rows
        channel = "translation.x" if rows.shape[1] == 1 else "translation"
        self.of(node)["translation"] = wide[0].tolist()
        codes, wide = thinned(codes, wide)
        if len(wide) > 1:
            self.writer.animate(
                node, "translation", self.source.seconds(codes), wide, "STEP" if steps else "LINEAR"
            )
        self.extra(node, "sunfleck_ctl", {"target": target, "channel": channel})
