"""Opening of stages. In goes a path, out come a stage, its clock and its units.

Invariant: a returned stage has no cyclic arcs; missing references are reported.
"""

import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from pxr import Pcp, Sdf, Tf, Usd, UsdGeom, UsdUtils

from ...errors import SceneError, ToolError
from .clock import put_rates_right, read_clock
from .losses import Losses
from .options import ImportOptions

MOST_CLIPS = 100_000
"""Maximum clips of a set."""
MOST_NAMED = 10
"""Maximum errors of one kind in a message."""
ENDLESS = (Pcp.ErrorArcCycle, Pcp.ErrorSublayerCycle, Pcp.ErrorCapacityExceeded)
MISSING = (
    Pcp.ErrorInvalidAssetPath,
    Pcp.ErrorInvalidSublayerPath,
    Pcp.ErrorUnresolvedPrimPath,
    Pcp.ErrorMutedAssetPath,
)


@dataclass(frozen=True)
class Source:
    """Opened stage. Codes are time codes, frames are frame numbers."""

    path: Path
    stage: Usd.Stage
    fps: Fraction
    codes_per_second: Fraction
    codes: np.ndarray
    by_blender: bool
    by_us: bool
    for_blender: bool

    def seconds(self, codes: np.ndarray) -> np.ndarray:
        """Times of time codes."""
        return np.asarray(codes, float) / float(self.codes_per_second)

    @property
    def first(self) -> float:
        """Code for constant values."""
        return float(self.codes[0])

    @property
    def frames(self) -> tuple[int, int]:
        """First and last frame."""
        rate = float(self.fps / self.codes_per_second)
        return round(self.codes[0] * rate), round(self.codes[-1] * rate)

    @cached_property
    def authored(self) -> Callable[[Usd.Prim], frozenset[str]]:
        """Names of a prim's authored properties, by one query in place of many."""
        # Several readers in a row query a prim and its parent.
        return lru_cache(maxsize=8)(lambda prim: frozenset(prim.GetAuthoredPropertyNames()))

    @property
    def metres(self) -> float:
        """Length of a stage unit."""
        return _metres(self.stage)


@contextmanager
def usd_said(path: Path) -> Iterator[None]:
    """Turns USD's errors about a file into `SceneError`, without output."""
    silenced = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    except Tf.ErrorException as error:
        raise SceneError(f"{path}: is no stage that can be read: {_said(error)}") from None
    except (TypeError, ValueError, OverflowError) as error:
        # Attributes may have any type; errors of numpy and Python about them are one fault.
        raise SceneError(f"{path}: holds a value that does not fit its place: {error}") from None
    except MemoryError:
        raise SceneError(f"{path}: needs more memory than there is") from None
    finally:
        silenced.TakeUncoalescedDiagnostics()


def open_stage(path: Path, options: ImportOptions, lost: Losses) -> Source:
    """Opens a stage, and reports missing files. Raises `SceneError` for cyclic arcs, `ToolError` if there
    is no file."""
    if not path.is_file():
        raise ToolError(f"{path}: cannot be read: there is no such file", is_usage=False)
    stage = Usd.Stage.Open(str(path))
    put_rates_right(stage, lost)
    for variant in options.variants:
        _choose(path, stage, *variant)
    if options.masks:
        stage = _masked(path, stage, options.masks)
    _say_what_is_missing(path, stage, lost)
    _put_unit_right(stage, lost)
    fps, codes_per_second, codes = read_clock(path, stage, options.frames, lost)
    by_blender = stage.GetRootLayer().documentation.startswith("Blender v")
    ours = stage.GetRootLayer().customLayerData.get("sunfleck")
    for_blender = isinstance(ours, dict) and ours.get("for") == "blender"
    return Source(path, stage, fps, codes_per_second, codes, by_blender, bool(ours), for_blender)


def _metres(stage: Usd.Stage) -> float:
    """Length of a unit in metres. Exporters also write it in single precision, which
    `UsdGeom.GetStageMetersPerUnit` rejects."""
    return float(stage.GetMetadata(UsdGeom.Tokens.metersPerUnit))


def _put_unit_right(stage: Usd.Stage, lost: Losses) -> None:
    """Replaces an invalid unit and axis by USD's defaults."""
    up = UsdGeom.GetStageUpAxis(stage)
    if up not in (UsdGeom.Tokens.y, UsdGeom.Tokens.z):
        lost.add("usd-unit", "/", f"up along {up} is neither Y nor Z; Y is taken")
    metres = _metres(stage)
    if not (math.isfinite(metres) and metres > 0):
        lost.add("usd-unit", "/", f"{metres:g} metres are no unit; 0.01 are taken")
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            stage.SetMetadata(UsdGeom.Tokens.metersPerUnit, UsdGeom.LinearUnits.centimeters)


def _choose(path: Path, stage: Usd.Stage, prim_path: str, set_name: str, choice: str) -> None:
    """Selects a variant, in place of the stage's own choice."""
    prim = _prim(path, stage, prim_path)
    sets = prim.GetVariantSets()
    if set_name not in sets.GetNames():
        there = ", ".join(sets.GetNames()) or "none"
        raise SceneError(f"{path}: {prim_path} has no variant set `{set_name}`; it has {there}")
    choices = sets.GetVariantSet(set_name).GetVariantNames()
    if choice not in choices:
        raise SceneError(
            f"{path}: the variant set `{set_name}` of {prim_path} has no `{choice}`; it has "
            f"{', '.join(choices)}"
        )
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        sets.GetVariantSet(set_name).SetVariantSelection(choice)


def _masked(path: Path, stage: Usd.Stage, masks: tuple[str, ...]) -> Usd.Stage:
    """Stage with only some paths, and their dependencies: materials, skeletons, prototypes."""
    mask = Usd.StagePopulationMask([_prim(path, stage, each).GetPath() for each in masks])
    masked = Usd.Stage.OpenMasked(stage.GetRootLayer(), stage.GetSessionLayer(), mask)
    masked.ExpandPopulationMask()
    return masked


def _prim(path: Path, stage: Usd.Stage, prim_path: str) -> Usd.Prim:
    is_path = Sdf.Path.IsValidPathString(prim_path) and prim_path.startswith("/")
    prim = stage.GetPrimAtPath(prim_path) if is_path else None
    if not prim:
        raise SceneError(f"{path}: there is no prim `{prim_path}`; expected a path such as /World/leaf")
    return prim


def _say_what_is_missing(path: Path, stage: Usd.Stage, lost: Losses) -> None:
    """Reports USD's composition errors; cyclic arcs are refused."""
    errors = stage.GetCompositionErrors()
    endless = [str(error).strip() for error in errors if isinstance(error, ENDLESS)]
    if endless:
        raise SceneError(f"{path}: does not hold together:\n" + listed(endless))
    for error in errors:
        kind = "usd-missing" if isinstance(error, MISSING) else "usd-composition"
        lost.add(kind, error.rootSite.path, " ".join(str(error).split()))
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.HasVariantSets():
            _say_what_is_chosen_in_vain(prim, lost)
        if prim.HasAuthoredMetadata("clips"):
            _say_which_clips_are_missing(prim, lost)


def _say_what_is_chosen_in_vain(prim: Usd.Prim, lost: Losses) -> None:
    """Reports selected variants that a set lacks; USD then selects none."""
    sets = prim.GetVariantSets()
    for name in sets.GetNames():
        chosen, there = sets.GetVariantSelection(name), sets.GetVariantSet(name).GetVariantNames()
        if chosen and chosen not in there:
            what = f"the variant set `{name}` has no `{chosen}`; it has {', '.join(there)}"
            lost.add("usd-missing", prim, what)


def _say_which_clips_are_missing(prim: Usd.Prim, lost: Losses) -> None:
    """Reports missing files of value clips; USD then ignores all clips of the prim."""
    api = Usd.ClipsAPI(prim)
    for name, clips in (api.GetClips() or {}).items():
        if not isinstance(clips, dict):
            continue
        layer = _layer_of_clips(prim)
        named = [str(each.path) for each in clips.get("assetPaths") or ()]
        template = clips.get("templateAssetPath")
        if template and not named:
            named = list(_of_template(str(template), clips))
        manifest = clips.get("manifestAssetPath")
        for path in [*named, *([manifest.path] if manifest and manifest.path else [])]:
            if not _opens(layer, path):
                what = f"the value clip `{path}` of the set `{name}` is not there, or cannot be read"
                lost.add("usd-missing", prim, what)


def _layer_of_clips(prim: Usd.Prim) -> Sdf.Layer:
    """Strongest layer with clips, to which their paths are relative."""
    specs = [spec for spec in prim.GetPrimStack() if spec.HasInfo("clips")]
    return specs[0].layer if specs else prim.GetStage().GetRootLayer()


def _opens(layer: Sdf.Layer, path: str) -> bool:
    try:
        return bool(path) and bool(Sdf.Layer.FindOrOpenRelativeToLayer(layer, path))
    except Tf.ErrorException:
        return False


def _of_template(template: str, clips: dict) -> Iterator[str]:
    """Files of a template such as `clip.###.usd` or `clip.###.##.usd`."""
    start, end, stride = (clips.get(f"template{name}", math.nan) for name in ("StartTime", "EndTime", "Stride"))
    found = re.fullmatch(r"([^#]*)(#+)(?:\.(#+))?([^#]*)", template)
    usable = all(isinstance(each, (int, float)) and math.isfinite(each) for each in (start, end, stride))
    if not found or not usable or stride <= 0:
        return
    head, whole, part, tail = found.groups()
    for number in range(min(int((end - start) / stride + 1e-6) + 1, MOST_CLIPS)):
        time = start + number * stride
        width = len(whole) + (len(part) + 1 if part else 0)
        yield f"{head}{time:0{width}.{len(part or '')}f}{tail}"


def _said(error: Exception) -> str:
    """Message without places in USD's own sources."""
    try:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    except UnicodeDecodeError:
        lines = []
    return lines[0].rpartition(": '")[2].rstrip("'") if lines else "it is damaged"


def listed(errors: list[str]) -> str:
    """First few errors, one a line."""
    shown = [f"  {' '.join(error.split())}" for error in errors[:MOST_NAMED]]
    return "\n".join(shown + ([f"  and {len(errors) - MOST_NAMED} more"] if len(errors) > MOST_NAMED else []))
