"""Subdivision surfaces, refined level by level.

Catmull and Clark 1978, Loop 1987; creases that are sharp for some levels by DeRose, Kass and Truong 1998
("Subdivision surfaces in character animation"). Choices beyond those papers are OpenSubdiv's, which
renderers of USD use: creases decay uniformly, edges of more than two faces are sharp. Invariant: refined
values are weighted means; weights add up to 1.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

SHARPEST = 10.0
"""Sharpness that never decays (OpenSubdiv's SHARPNESS_INFINITE)."""
SMOOTH_TRIANGLE = 0.470
"""Weight of a triangle's centre by the rule `smooth` (Stam and Loop 2003, as in
OpenSubdiv); a quad's is 1/4."""


@dataclass(frozen=True)
class Cage:
    """Faces to refine: corners a face, vertices of the corners, and sharpness.

    `crease_ends` are pairs of vertices, `crease_sharpness` a number for each; `vertex_sharpness` is a
    number for each vertex.
    """

    counts: np.ndarray
    corners: np.ndarray
    crease_ends: np.ndarray
    crease_sharpness: np.ndarray
    vertex_sharpness: np.ndarray
    is_loop: bool = False
    smooth_triangles: bool = False

    @property
    def vertices(self) -> int:
        """Number of vertices."""
        return len(self.vertex_sharpness)

    @cached_property
    def starts(self) -> np.ndarray:
        """First corner of each face."""
        return np.cumsum(self.counts) - self.counts

    @cached_property
    def face_of_corner(self) -> np.ndarray:
        """Face of each corner."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    @cached_property
    def next_corner(self) -> np.ndarray:
        """Next corner around the face."""
        following = np.arange(1, len(self.corners) + 1)
        following[self.starts + self.counts - 1] = self.starts
        return following

    @cached_property
    def corner_before(self) -> np.ndarray:
        """Previous corner around the face."""
        before = np.empty(len(self.corners), np.int64)
        before[self.next_corner] = np.arange(len(self.corners))
        return before

    @cached_property
    def edges(self) -> "Edges":
        """Unique edges."""
        starts, ends = self.corners, self.corners[self.next_corner]
        numbers = np.minimum(starts, ends) * self.vertices + np.maximum(starts, ends)
        keys, of_corner, faces = np.unique(numbers, return_inverse=True, return_counts=True)
        sharpness = np.zeros(len(keys))
        if len(self.crease_ends):
            wanted = self.crease_ends.min(axis=1) * self.vertices + self.crease_ends.max(axis=1)
            places = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
            there = keys[places] == wanted
            np.maximum.at(sharpness, places[there], self.crease_sharpness[there])
        sharpness[(faces != 2) | (sharpness >= SHARPEST)] = np.inf
        return Edges(np.stack(np.divmod(keys, self.vertices), axis=1), of_corner.ravel(), faces, sharpness)

    @property
    def faces_at_vertex(self) -> np.ndarray:
        """Number of faces at each vertex."""
        return np.bincount(self.corners, minlength=self.vertices)

    def with_sharp_vertices(self, chosen: np.ndarray) -> "Cage":
        """The same cage with chosen vertices fixed."""
        return replace(self, vertex_sharpness=np.where(chosen, np.inf, self.vertex_sharpness))


@dataclass(frozen=True)
class Edges:
    """For each edge: its two vertices, its number of faces, its sharpness; for each corner the edge to the
    next one."""

    ends: np.ndarray
    of_corner: np.ndarray
    faces: np.ndarray
    sharpness: np.ndarray


class Refinement:
    """One level: a cage, the finer one, and the weights of vertices from one to the other.

    The finer vertices are those of the cage, then one for each edge, then (Catmull-Clark) one for each
    face.
    """

    def __init__(self, cage: Cage):
        self.cage = cage
        self._weigh_edges()
        self._weigh_vertices()

    def _weigh_edges(self) -> None:
        """Weights of an edge's midpoint and of adjacent centres for its vertex."""
        cage, edges = self.cage, self.cage.edges
        sharp = np.minimum(edges.sharpness, 1.0)
        # Loop's (3, 3, 1, 1) / 8 by the centres of both triangles.
        beside = np.full(len(sharp), 0.375 if cage.is_loop else 0.25)
        if cage.smooth_triangles and not cage.is_loop:
            of_face = np.where(cage.counts == 3, SMOOTH_TRIANGLE, 0.25)
            beside = np.bincount(edges.of_corner, of_face[cage.face_of_corner], len(sharp)) / edges.faces
        self.edge_by_face = (1 - sharp) * beside
        self.edge_by_middle = 1 - 2 * self.edge_by_face

    def _weigh_vertices(self) -> None:
        """Weights of a vertex, its neighbours and adjacent centres for its new position."""
        edges, sharpness = self.cage.edges, self.cage.vertex_sharpness
        before = self._rule(edges.sharpness, sharpness)
        after = self._rule(edges.sharpness - 1, sharpness - 1)
        # Sharpness that ends at this level: the mean over a vertex's edges, and its own.
        ending = np.where((edges.sharpness > 0) & (edges.sharpness <= 1), edges.sharpness, 0.0)
        own = np.where((sharpness > 0) & (sharpness <= 1), sharpness, 0.0)
        total = self._at_ends(np.stack([ending, ending], axis=1)) + own
        number = self._at_ends(np.stack([ending > 0, ending > 0], axis=1)) + (own > 0)
        is_same = before.kind == after.kind
        share = np.where(is_same, 1.0, total / np.maximum(number, 1))
        at_end = share[edges.ends]
        self.own = share * before.own + (1 - share) * after.own
        self.by_end = at_end * before.by_end + (1 - at_end) * after.by_end
        self.by_face = share * before.by_face + (1 - share) * after.by_face

    def _at_ends(self, values: np.ndarray) -> np.ndarray:
        """Sum at each vertex of values for both ends of each edge."""
        return np.bincount(self.cage.edges.ends.ravel(), values.ravel(), self.cage.vertices)

    def _rule(self, edge_sharpness: np.ndarray, vertex_sharpness: np.ndarray) -> "_Rule":
        """Rule of each vertex by its number of sharp edges: smooth (or dart), crease, or corner (DeRose,
        Kass and Truong 1998, section 3)."""
        is_sharp = np.repeat((edge_sharpness > 0)[:, None], 2, axis=1)
        sharp = self._at_ends(is_sharp)
        valence = self._at_ends(np.ones_like(is_sharp))
        kind = np.where((vertex_sharpness > 0) | (sharp > 2) | (valence < 2), 2, np.where(sharp == 2, 1, 0))
        n = np.maximum(valence, 1.0)
        if self.cage.is_loop:
            smooth = (0.625 - (0.375 + 0.25 * np.cos(2 * np.pi / n)) ** 2) / n
            own, by_face = 1 - n * smooth, np.zeros(len(n))
        else:
            smooth = 1 / n**2
            own, by_face = 1 - 2 / n, smooth
        kind_at_end = kind[self.cage.edges.ends]
        by_end = np.where(
            kind_at_end == 0,
            smooth[self.cage.edges.ends],
            np.where((kind_at_end == 1) & is_sharp, 0.125, 0.0),
        )
        return _Rule(kind, np.choose(kind, [own, 0.75, 1.0]), by_end, np.where(kind == 0, by_face, 0.0))

    def smooth(self, values: np.ndarray) -> np.ndarray:
        """Values of vertices, refined by the scheme's rules: positions, and primvars of
        interpolation `vertex`."""
        cage, edges = self.cage, self.cage.edges
        centers = self._centers(values)
        about = centers[cage.face_of_corner]
        ends = values[edges.ends]
        at_edges = 0.5 * (ends[:, 0] + ends[:, 1]) * self.edge_by_middle[:, None]
        at_edges += sums(edges.of_corner, about, len(edges.ends)) * self.edge_by_face[:, None]
        others = (ends[:, ::-1] * self.by_end[:, :, None]).reshape(-1, values.shape[1])
        at_vertices = values * self.own[:, None] + sums(edges.ends.ravel(), others, cage.vertices)
        at_vertices += sums(cage.corners, about, cage.vertices) * self.by_face[:, None]
        return np.concatenate([at_vertices, at_edges] + ([] if cage.is_loop else [centers]))

    def linear(self, values: np.ndarray) -> np.ndarray:
        """Values of vertices, refined linearly: primvars of interpolation `varying`."""
        ends = values[self.cage.edges.ends]
        middles = 0.5 * (ends[:, 0] + ends[:, 1])
        return np.concatenate([values, middles] + ([] if self.cage.is_loop else [self._centers(values)]))

    def _centers(self, values: np.ndarray) -> np.ndarray:
        sums = np.add.reduceat(values[self.cage.corners], self.cage.starts, axis=0)
        return sums / self.cage.counts[:, None]

    @property
    def parents(self) -> np.ndarray:
        """Face of the cage for each finer face."""
        return (
            np.repeat(np.arange(len(self.cage.counts)), 4) if self.cage.is_loop else self.cage.face_of_corner
        )

    @cached_property
    def finer(self) -> Cage:
        """Cage of the next level, of quads or triangles."""
        cage, edges = self.cage, self.cage.edges
        at_edge = cage.vertices + edges.of_corner
        before = np.empty(len(at_edge), np.int64)
        before[cage.next_corner] = at_edge
        if cage.is_loop:
            tips = np.stack([cage.corners, at_edge, before], axis=1).reshape(-1, 3, 3)
            corners = np.concatenate([tips, at_edge.reshape(-1, 1, 3)], axis=1).reshape(-1, 3)
        else:
            centers = cage.vertices + len(edges.ends) + cage.face_of_corner
            corners = np.stack([cage.corners, at_edge, centers, before], axis=1)
        left = edges.sharpness - 1
        kept = np.nonzero(left > 0)[0]
        halves = np.stack(
            [edges.ends[kept], np.repeat(cage.vertices + kept[:, None], 2, axis=1)], axis=2
        ).reshape(-1, 2)
        added = len(edges.ends) + (0 if cage.is_loop else len(cage.counts))
        sharp = np.concatenate([np.maximum(cage.vertex_sharpness - 1, 0), np.zeros(added)])
        return replace(
            cage,
            counts=np.full(len(corners), corners.shape[1]), corners=corners.ravel(), vertex_sharpness=sharp,
            crease_ends=halves, crease_sharpness=np.repeat(left[kept], 2),
        )  # fmt: skip


@dataclass(frozen=True)
class _Rule:
    """Rule of each vertex (0 smooth, 1 crease, 2 corner), and the weights."""

    kind: np.ndarray
    own: np.ndarray
    by_end: np.ndarray
    by_face: np.ndarray


def sums(places: np.ndarray, rows: np.ndarray, count: int) -> np.ndarray:
    """Sum of the rows with each index."""
    width = rows.shape[1]
    bins = (places[:, None] * width + np.arange(width)).ravel()
    return np.bincount(bins, rows.ravel(), count * width).reshape(count, width)


def refined(cage: Cage, levels: int) -> list[Refinement]:
    """Levels of refinement, each of the previous one."""
    found = []
    for _ in range(levels):
        found.append(Refinement(cage))
        cage = found[-1].finer
    return found
