"""Matrices as translations, rotations and scales of glTF."""

import numpy as np
from pxr import Usd, UsdGeom

from ...errors import SceneError
from .source import Source

LARGEST = 1e15
"""Maximum element of matrices, as in the renderer."""
SHEAR = 1e-5
"""Tolerance of the cosine between orthogonal axes."""
RESET = "!resetXformStack!"
"""Operation that resets the parent's transform."""
STILL = np.eye(4)[None]
STILL.setflags(write=False)


def reach(codes: np.ndarray) -> tuple[float, float]:
    """Range of time codes extended by a frame on either side, as shutters may reach; glTF has no times
    before 0."""
    frame = codes[1] - codes[0] if len(codes) > 1 else 1.0
    return max(float(codes[0] - frame), 0.0), float(codes[-1] + frame)


def codes_of(attributes: list[Usd.Attribute], codes: np.ndarray) -> np.ndarray:
    """Whole frames, samples between them, and the shutters' reach beyond, if any attribute moves; else the
    first frame."""
    moving = [attribute for attribute in attributes if attribute.ValueMightBeTimeVarying()]
    if not moving:
        return codes[:1]
    samples = np.array([code for attribute in moving for code in attribute.GetTimeSamples()], float)
    splines = any(attribute.HasSpline() for attribute in moving)
    first, last = reach(codes)
    found = [codes, samples[(samples > first) & (samples < last)]]
    if splines or (samples < codes[0]).any():
        found.append(np.array([first]))
    if splines or (samples > codes[-1]).any():
        found.append(np.array([last]))
    return np.unique(np.round(np.concatenate(found), 6))


def is_carried(prim: Usd.Prim) -> bool:
    """True if velocities move points or instances, even from a single sample."""
    attributes = [prim.GetAttribute(name) for name in ("velocities", "angularVelocities")]
    return any(attribute and attribute.GetNumTimeSamples() > 0 for attribute in attributes)


def while_carried(moves: np.ndarray, codes: np.ndarray) -> np.ndarray:
    """Codes of a motion, joined by all whole frames and the shutters' reach beyond."""
    return np.unique(np.round(np.concatenate([moves, codes, reach(codes)]), 6))


def is_placed(prim: Usd.Prim, source: Source) -> bool:
    """True if a prim has a transform of its own."""
    return UsdGeom.Tokens.xformOpOrder in source.authored(prim)


def is_reset(prim: Usd.Prim, source: Source) -> bool:
    """True if a prim's transform leads directly to the world, whatever its parent's."""
    return is_placed(prim, source) and RESET in (prim.GetAttribute("xformOpOrder").Get() or ())


def local_matrices(prim: Usd.Prim, source: Source) -> tuple[np.ndarray, np.ndarray]:
    """Codes, and matrices for column vectors. Raises `SceneError`."""
    if not is_placed(prim, source):
        return source.codes[:1], STILL
    xformable = UsdGeom.Xformable(prim)
    operations = xformable.GetOrderedXformOps()
    codes = codes_of([operation.GetAttr() for operation in operations], source.codes)
    matrices = np.empty((len(codes), 4, 4))
    for row, code in enumerate(codes.tolist()):
        matrices[row] = xformable.GetLocalTransformation(operations, Usd.TimeCode(code))
    # NaN fails this comparison too.
    if not np.abs(matrices).max() < LARGEST:
        raise SceneError(f"{prim.GetPath()}: its place is not finite")
    return codes, matrices.transpose(0, 2, 1)


def parts(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, bool]:
    """Translations, quaternions (x, y, z, w), scales, and whether they suffice, without shear."""
    linear = matrices[:, :3, :3]
    scales = np.linalg.norm(linear, axis=1)
    axes = linear / np.where(scales > 0, scales, 1.0)[:, None, :]
    products = np.abs(axes.transpose(0, 2, 1) @ axes)
    off_diagonal = products * (1 - np.eye(3))
    axes = np.where((scales > 0).all(axis=1)[:, None, None], axes, np.eye(3))
    mirrored = np.linalg.det(axes) < 0
    axes[mirrored] *= -1
    scales[mirrored] *= -1
    return matrices[:, :3, 3], steady(quaternions(axes)), scales, bool(off_diagonal.max() < SHEAR)


def sheared(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Matrices as rotation, scale, rotation: quaternions of the outer rotation, scales, quaternions of the
    inner one."""
    outer, scales, inner = np.linalg.svd(matrices[:, :3, :3])
    for turn in (outer, inner):
        mirrored = np.linalg.det(turn) < 0
        turn[mirrored] *= -1
        scales[mirrored] *= -1
    return steady(quaternions(outer)), scales, steady(quaternions(inner))


def quaternions(turns: np.ndarray) -> np.ndarray:
    """Quaternions of rotation matrices, by the largest of the four numbers (Shepperd 1978)."""
    m = turns
    trace = np.trace(m, axis1=1, axis2=2)
    squares = np.array([*(1 + 2 * np.diagonal(m, axis1=1, axis2=2).T - trace), 1 + trace])
    a, b, c = m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]
    xy, xz, yz = m[:, 0, 1] + m[:, 1, 0], m[:, 0, 2] + m[:, 2, 0], m[:, 1, 2] + m[:, 2, 1]
    x, y, z, w = squares
    table = np.array([[x, xy, xz, a], [xy, y, yz, b], [xz, yz, z, c], [a, b, c, w]])
    chosen = table[np.argmax(squares, axis=0), :, np.arange(len(m))]
    return chosen / np.linalg.norm(chosen, axis=1, keepdims=True)


def turn_of(quaternion: list[float]) -> np.ndarray:
    """Rotation matrix of a unit quaternion (x, y, z, w)."""
    x, y, z, w = quaternion
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * (w * skew + skew @ skew)


def steady(turns: np.ndarray) -> np.ndarray:
    """The same rotations, each with the sign nearer to its predecessor."""
    if len(turns) < 2:
        return turns
    flips = np.sum(turns[1:] * turns[:-1], axis=1) < 0
    signs = np.concatenate([[1.0], np.where(flips, -1.0, 1.0)]).cumprod()
    return turns * signs[:, None]
