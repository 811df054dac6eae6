"""Stages of many meshes, and what it costs to import them: processor seconds, and megabytes at most.

python -m tests.many_meshes            (in tools/)
python -m tests.many_meshes 10,000     (those stages alone whose names have this)
"""

import resource
import sys
import tempfile
import time
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade, Vt

MATERIALS = 5


@dataclass(frozen=True)
class Many:
    """How many grids of `side` points squared, over how many frames: moved by `modes` shapes, or by
    chance if there are none."""

    meshes: int
    side: int = 4
    frames: int = 1
    modes: int = 0
    scheme: str | None = "none"


STAGES = {
    "10,000 meshes that stay": Many(10_000),
    "10,000 subdivision surfaces": Many(10_000, scheme=None),
    "1,000 meshes that bend in 5 ways": Many(1_000, 32, 100, 5),
    "100 meshes that crumple": Many(100, 32, 100),
}


def make_stage(path: Path, many: Many) -> None:
    """Writes a stage; grids of one material in turn, in rows of a hundred."""
    random = np.random.default_rng(0)
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Y")
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(many.frames)
    at = np.arange(many.side**2).reshape(many.side, many.side)
    corners = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1).ravel().astype(np.int32)
    u, v = (each.ravel() for each in np.meshgrid(*[np.linspace(0, 1, many.side)] * 2, indexing="ij"))
    for number in range(MATERIALS):
        material, shader = (
            kind.Define(stage, f"/m{number}{end}")
            for kind, end in ((UsdShade.Material, ""), (UsdShade.Shader, "/s"))
        )
        shader.CreateIdAttr("UsdPreviewSurface")
        material.CreateSurfaceOutput().ConnectToSource(
            shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
        )
    for number in range(many.meshes):
        place = UsdGeom.Xform.Define(stage, f"/x{number}")
        place.AddTranslateOp().Set((number % 100, 0, number // 100))
        mesh = UsdGeom.Mesh.Define(stage, f"/x{number}/mesh")
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(corners) // 4, 4))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners))
        if many.scheme is not None:
            mesh.CreateSubdivisionSchemeAttr(many.scheme)
        rest = np.stack([u, 0.1 * random.random(len(u)), v], axis=1)
        modes = 0.1 * random.standard_normal((many.modes, len(u), 3))
        points = mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(rest.astype(np.float32)))
        for frame in range(1, many.frames + 1) if many.frames > 1 else ():
            by = np.sin(0.1 * frame * (1 + np.arange(many.modes)))
            moved = (
                np.einsum("m,mpi->pi", by, modes) if many.modes else 0.1 * random.standard_normal(rest.shape)
            )
            points.Set(Vt.Vec3fArray.FromNumpy((rest + moved).astype(np.float32)), frame)
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
        primvar.Set(Vt.Vec2fArray.FromNumpy(np.stack([u, v], axis=1).astype(np.float32)))
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(
            UsdShade.Material.Get(stage, f"/m{number % MATERIALS}")
        )
    stage.GetRootLayer().Save()


def cost(path: Path) -> tuple[float, float, float]:
    """Processor seconds and megabytes of an import, and megabytes of the file."""
    from sunfleck_tools.usd import import_usd

    began, target = time.process_time(), path.with_suffix(".glb")
    import_usd(path, target)
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return time.process_time() - began, most, target.stat().st_size / 1e6


def main() -> None:
    """Prints a line for each stage that is asked for."""
    context = get_context("spawn")
    asked = sys.argv[1] if len(sys.argv) > 1 else ""
    for name, many in STAGES.items():
        if asked not in name:
            continue
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "many.usdc"
            # A process each, for memory that is once taken stays so.
            with context.Pool(1) as pool:
                pool.apply(make_stage, (path, many))
            with context.Pool(1) as pool:
                seconds, most, size = pool.apply(cost, (path,))
        print(f"{name:34} {seconds:6.1f} s {most:7.0f} MB at most, {size:7.1f} MB written", flush=True)


if __name__ == "__main__":
    main()
