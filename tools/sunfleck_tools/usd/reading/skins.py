"""Skeletons of UsdSkel as skins of glTF, or where these would differ, as points baked over time.

In go the roots of a stage, and later their meshes. Out come joints as nodes below their skeleton, with
joint weights. Invariant: a root is skinned or baked as a whole; a skin's vertices are UsdSkel's at every
sample.
"""

from dataclasses import dataclass, field

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdSkel

from .losses import UNREADABLE, Losses
from .nodes import Nodes
from .places import codes_of, reach
from .shapes import Shape
from .source import Source

A_SET = 4
"""Joints a vertex in each pair of glTF's attributes."""
SUM_TOLERANCE = 1e-3
"""Tolerance of a weight sum of 1: UsdSkel uses weights as they are, glTF renderers normalize them."""
PREDICATE = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)


@dataclass
class _Tied:
    """Mesh on a skeleton: joints (a row of indices a point), weights, and the bind transform."""

    skeleton: UsdSkel.SkeletonQuery
    joints: np.ndarray
    weights: np.ndarray
    skeleton_from_mesh: Gf.Matrix4d


@dataclass
class _Bones:
    """Skeleton whose joints become nodes: its node, and the skins that wait for it."""

    query: UsdSkel.SkeletonQuery
    node: int | None = None
    skins: dict[tuple, int] = field(default_factory=dict)


class Skins:
    """Skeletons of a stage."""

    def __init__(self, source: Source, nodes: Nodes, lost: Losses):
        self.source, self.nodes, self.lost = source, nodes, lost
        self.cache = UsdSkel.Cache()
        self._tied: dict[str, _Tied] = {}
        self._bones: dict[str, _Bones] = {}

    def prepare(self) -> None:
        """Finds the skeletons that can be skins; others, and blend shapes, are baked to points in the
        session layer."""
        stage = self.source.stage
        session = stage.GetSessionLayer()
        # Otherwise time codes would be scaled between the layers.
        session.timeCodesPerSecond = stage.GetTimeCodesPerSecond()
        stage.SetEditTarget(session)
        for prim in list(stage.Traverse()):
            if prim.IsInstance() and any(
                each.IsA(UsdSkel.Root) for each in Usd.PrimRange(prim.GetPrototype())
            ):
                prim.SetInstanceable(False)
        prims = list(stage.Traverse())
        # A prototype has many instances, and its joints would have to follow each.
        is_crowded = any(prim.IsA(UsdGeom.PointInstancer) for prim in prims)
        span = Gf.Interval(*reach(self.source.codes))
        for root in [UsdSkel.Root(prim) for prim in prims if prim.IsA(UsdSkel.Root)]:
            if (is_crowded or not self._ties(root)) and not UsdSkel.BakeSkinning(root, span):
                self.lost.add("usd-skeleton", root, "its skeleton cannot be followed; it rests")

    def stands(self, prim: Usd.Prim, node: int) -> None:
        """Sets the node of a skeleton."""
        if self._bones and (bones := self._bones.get(str(prim.GetPath()))):
            bones.node = node

    def tie(self, prim: Usd.Prim, parts: list[Shape]) -> int | None:
        """Binds the vertices of a mesh to joints; returns the index of their skin, or None."""
        tied = self._tied.get(str(prim.GetPath())) if self._tied else None
        if tied is None:
            return None
        for part in parts:
            joints, weights = tied.joints[part.point_of_row], tied.weights[part.point_of_row]
            for number in range(joints.shape[1] // A_SET):
                columns = slice(A_SET * number, A_SET * (number + 1))
                part.attributes[f"JOINTS_{number}"] = joints[:, columns]
                part.attributes[f"WEIGHTS_{number}"] = weights[:, columns]
        bones = self._bones[str(tied.skeleton.GetPrim().GetPath())]
        key = tuple(map(tuple, tied.skeleton_from_mesh))
        if key not in bones.skins:
            # USD's matrices for row vectors have the order of glTF's for column vectors.
            matrices = [
                tied.skeleton_from_mesh * bind.GetInverse()
                for bind in tied.skeleton.GetJointWorldBindTransforms()
            ]
            inverse = self.nodes.writer.floats(np.array(matrices, float).reshape(-1, 16))
            bones.skins[key] = self.nodes.writer.add("skins", {"inverseBindMatrices": inverse})
        return bones.skins[key]

    def finish(self) -> None:
        """Writes the joints, once every skeleton has a node."""
        for path, bones in self._bones.items():
            if not bones.skins:
                continue
            joints = self._joints(bones)
            for number in bones.skins.values():
                skin = self.nodes.writer.document["skins"][number]
                skin.update(name=path.rpartition("/")[2], joints=joints)

    def _joints(self, bones: _Bones) -> list[int]:
        query = bones.query
        animation = UsdSkel.Animation(query.GetAnimQuery().GetPrim()) if query.GetAnimQuery() else None
        moving = (
            [animation.GetTranslationsAttr(), animation.GetRotationsAttr(), animation.GetScalesAttr()]
            if animation
            else []
        )
        codes = codes_of(moving, self.source.codes)
        # code, joint: parents from joints
        locals_ = np.array(
            [query.ComputeJointLocalTransforms(Usd.TimeCode(code)) for code in codes.tolist()], float
        )
        locals_ = locals_.reshape(len(codes), -1, 4, 4).transpose(1, 0, 3, 2)
        found: list[int] = []
        for name, parent, matrices in zip(
            query.GetJointOrder(), query.GetTopology().GetParentIndices(), locals_
        ):
            node = self.nodes.add(name.rpartition("/")[2], bones.node if parent < 0 else found[parent])
            found.append(self.nodes.place(node, codes, matrices))
        return found

    def _ties(self, root: UsdSkel.Root) -> bool:
        """Binds all meshes of a root, if skins move all of them as UsdSkel does."""
        self.cache.Populate(root, PREDICATE)
        found: dict[str, _Tied] = {}
        for binding in self.cache.ComputeSkelBindings(root, PREDICATE):
            query = self.cache.GetSkelQuery(binding.GetSkeleton())
            for target in binding.GetSkinningTargets():
                tied = _tied(root, query, target)
                if tied is None:
                    return False
                found[str(target.GetPrim().GetPath())] = tied
        for tied in found.values():
            self._bones.setdefault(str(tied.skeleton.GetPrim().GetPath()), _Bones(tied.skeleton))
        self._tied.update(found)
        return bool(found)


def _tied(root: UsdSkel.Root, query: UsdSkel.SkeletonQuery, target: UsdSkel.SkinningQuery) -> _Tied | None:
    """Binding of a mesh to a skeleton; None if a glTF skin would move it differently."""
    prim = target.GetPrim()
    if not _is_still_mesh(prim) or target.HasBlendShapes() or not target.HasJointInfluences():
        return None
    is_below = query and query.GetPrim().GetPath().HasPrefix(root.GetPath())
    if not is_below or not query.HasBindPose() or target.GetSkinningMethod() != UsdSkel.Tokens.classicLinear:
        return None
    try:
        influences = target.ComputeVaryingJointInfluences(len(UsdGeom.Mesh(prim).GetPointsAttr().Get()))
        joints: np.ndarray
        joints, weights = (
            np.array(each).reshape(-1, target.GetNumInfluencesPerComponent()) for each in influences
        )
    except UNREADABLE:
        return None
    names = list(query.GetJointOrder())
    order = list(target.GetJointOrder() or names)
    if not _is_whole(joints, weights, len(order)) or not set(order) <= set(names):
        return None
    joints = np.array([names.index(name) for name in order])[joints]
    if len(query.GetJointWorldBindTransforms()) != len(names) or not _can_be_undone(query):
        return None
    missing = ((0, 0), (0, -joints.shape[1] % A_SET))
    joints = np.where(weights > 0, joints, 0)
    return _Tied(query, np.pad(joints, missing), np.pad(weights, missing), target.GetGeomBindTransform())


def _is_still_mesh(prim: Usd.Prim) -> bool:
    """Whether a mesh is not refined: otherwise the cage deforms, and points between are no longer means of
    joints."""
    if not prim.IsA(UsdGeom.Mesh) or prim.IsInstanceProxy():
        return False
    mesh = UsdGeom.Mesh(prim)
    attributes = (
        mesh.GetPointsAttr(),
        mesh.GetNormalsAttr(),
        mesh.GetFaceVertexCountsAttr(),
        mesh.GetFaceVertexIndicesAttr(),
    )
    is_flat = mesh.GetSubdivisionSchemeAttr().Get() == UsdGeom.Tokens.none
    return is_flat and not any(attribute.ValueMightBeTimeVarying() for attribute in attributes)


def _is_whole(joints: np.ndarray, weights: np.ndarray, count: int) -> bool:
    if (
        not joints.size
        or joints.shape != weights.shape
        or joints.min() < 0
        or joints.max() >= min(count, 1 << 16)
    ):
        return False
    return bool((weights >= 0).all() and (np.abs(weights.sum(axis=1) - 1) <= SUM_TOLERANCE).all())


def _can_be_undone(query: UsdSkel.SkeletonQuery) -> bool:
    return all(abs(bind.GetDeterminant()) > 1e-12 for bind in query.GetJointWorldBindTransforms())
