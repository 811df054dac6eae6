"""Nodes of the shown scene, with their motion. Invariant: parents come before children, and form trees."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import reduce

import numpy as np

from .accessors import Accessors
from .curves import Curve, unit
from .values import Value

RESTS = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0, 1.0, 1.0)}


@dataclass
class Node:
    """Node. `key` is its unique name in `sunfleck inspect --json`."""

    index: int
    name: str
    key: str
    parent: "Node | None"
    source: Value
    matrix: np.ndarray | None
    rest: dict[str, np.ndarray]
    curves: dict[str, Curve] = field(default_factory=dict)
    weights: Curve | None = None
    # Whether it and its descendants are visible: 0 is not.
    shown: Curve | None = None
    children: "list[Node]" = field(default_factory=list)

    @property
    def extras(self) -> Value:
        """Custom properties."""
        return self.source.extras

    @property
    def is_shown(self) -> bool:
        """Whether it is visible by itself where its visibility has no keys."""
        said = self.source.group("extensions").group("KHR_node_visibility").member("visible")
        return said is None or said.raw is not False

    @property
    def upwards(self) -> "Iterator[Node]":
        """The node and its ancestors."""
        above: Node | None = self
        while above is not None:
            yield above
            above = above.parent

    def parts_at(self, path: str, times_s: np.ndarray) -> np.ndarray:
        """Rows of one part of the transform, a row a time."""
        curve = self.curves.get(path)
        return np.tile(self.rest[path], (len(times_s), 1)) if curve is None else curve.at(times_s)

    def parent_from_node(self, times_s: np.ndarray) -> np.ndarray:
        """Matrices for column vectors."""
        if self.matrix is not None:
            return np.tile(self.matrix, (len(times_s), 1, 1))
        return matrices(*(self.parts_at(path, times_s) for path in RESTS))

    def world_from_node(self, times_s: np.ndarray) -> np.ndarray:
        """Matrices for column vectors."""
        return reduce(lambda below, above: above @ below, (node.parent_from_node(times_s) for node in self.upwards))


def matrices(translation: np.ndarray, rotation: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Matrices from translations, rotations and scales, row by row."""
    x, y, z, w = np.moveaxis(unit(rotation), -1, 0)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    found = np.zeros((len(translation), 4, 4))
    found[:, :3, :3] = np.moveaxis(turn, -1, 0) * scale[:, None, :]
    found[:, :3, 3] = translation
    found[:, 3, 3] = 1.0
    return found


def read_nodes(document: Value, scene: Value) -> list[Node]:
    """All nodes of a scene."""
    sources = document.items("nodes")
    children = [[child.index(sources, "node") for child in source.items("children")] for source in sources]
    roots = [root.index(sources, "node") for root in scene.items("nodes")] if scene.raw else _roots(children)
    parents: dict[int, int | None] = dict.fromkeys(roots)
    pending = list(reversed(roots))
    order: list[int] = []
    if len(parents) != len(roots):
        scene.fail("lists a node twice")
    while pending:
        index = pending.pop()
        order.append(index)
        for child in reversed(children[index]):
            if child in parents:
                sources[child].fail("has two parents, or is its own ancestor: nodes form trees")
            parents[child] = index
            pending.append(child)
    keys = _keys(sources, sorted(parents))
    nodes: dict[int, Node] = {}
    for index in order:
        above = parents[index]
        parent = None if above is None else nodes[above]
        nodes[index] = _node(index, sources[index], keys[index], parent)
        if parent is not None:
            parent.children.append(nodes[index])
    return list(nodes.values())


def _roots(children: list[list[int]]) -> list[int]:
    below = {child for each in children for child in each}
    return [index for index in range(len(children)) if index not in below]


def _keys(sources: list[Value], indices: list[int]) -> dict[int, str]:
    counts: dict[str, int] = {}
    keys = {}
    for index in indices:
        name = node_name(sources[index], index)
        counts[name] = counts.get(name, 0) + 1
        keys[index] = name if counts[name] == 1 else f"{name}#{counts[name]}"
    return keys


def node_name(source: Value, index: int) -> str:
    """Name of a node without one, as in `sunfleck`."""
    return source.text_at("name") or f"node {index}"


def _node(index: int, source: Value, key: str, parent: Node | None) -> Node:
    matrix = source.member("matrix")
    rest = {path: np.array(source.numbers_at(path, *RESTS[path])) for path in RESTS}
    rest["rotation"] = unit(rest["rotation"])
    placed = None if matrix is None else np.array(matrix.numbers(16)).reshape(4, 4).T
    return Node(index, node_name(source, index), key, parent, source, placed, rest)


def read_animations(document: Value, nodes: list[Node], accessors: Accessors) -> None:
    """Sets the nodes' curves: all animations play together; the last one for a property counts."""
    by_index = {node.index: node for node in nodes}
    sources = document.items("nodes")
    for animation in document.items("animations"):
        samplers = animation.items("samplers")
        for channel in animation.items("channels"):
            target = channel.need("target")
            sampler = channel.need("sampler").item_of(samplers, "sampler")
            if (of := target.member("node")) is None:
                _read_visibility(target, sampler, by_index, accessors)
                continue
            node = by_index.get(of.index(sources, "node"))
            path = target.text_at("path")
            if node is None:
                continue
            if path == "weights":
                node.weights = _curve(sampler, accessors, 1, turns=False)
            elif path in RESTS:
                node.curves[path] = _curve(sampler, accessors, len(RESTS[path]), turns=path == "rotation")


def _read_visibility(target: Value, sampler: Value, by_index: dict[int, Node], accessors: Accessors) -> None:
    """Reads a pointer to a node's visibility; other pointers are ignored."""
    pointer = target.group("extensions").group("KHR_animation_pointer").text_at("pointer")
    found = re.fullmatch("/nodes/([0-9]+)/extensions/KHR_node_visibility/visible", pointer)
    if found and (node := by_index.get(int(found[1]))) is not None:
        curve = _curve(sampler, accessors, 1, turns=False)
        node.shown = Curve(curve.times_s, curve.values, "STEP", turns=False)


def _curve(sampler: Value, accessors: Accessors, width: int, turns: bool) -> Curve:
    times = accessors.floats(sampler.need("input"), 1)[:, 0]
    values = accessors.floats(sampler.need("output"), width)
    interpolation = sampler.text_at("interpolation", "LINEAR")
    if interpolation not in ("LINEAR", "STEP", "CUBICSPLINE"):
        sampler.fail(f"`{interpolation}` is no interpolation")
    if len(times) == 0 or not (np.diff(times) > 0).all():
        sampler.fail("expected times that ascend")
    rows = len(times) * (3 if interpolation == "CUBICSPLINE" else 1)
    if len(values) % rows or (width > 1 and len(values) != rows) or len(values) == 0:
        sampler.fail(f"has {len(times)} times and {len(values)} values")
    # Weights: a row has as many numbers as the mesh has targets.
    return Curve(times, values.reshape(rows, -1), interpolation, turns)
