"""What a stage holds of the scene as a whole: its sky, settings and cameras. Invariant: the renderer's own properties
override what USD says otherwise."""

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from ..properties import SPACE
from ..surroundings import ENVIRONMENT, OF_SCENE
from .domes import picture_uri, read_dome
from .losses import Losses
from .nodes import Nodes
from .options import ImportOptions
from .properties import read_properties
from .render_settings import Lenses, take_exposure, take_render_settings
from .source import Source
from .visibility import seen, up_to


def ours_from_stage(source: Source) -> np.ndarray:
    """Matrix that converts the stage's axes and unit."""
    turn = np.eye(4)
    if UsdGeom.GetStageUpAxis(source.stage) == UsdGeom.Tokens.z:
        turn[1:3, 1:3] = [[0, 1], [-1, 0]]
    turn[:3, :3] *= source.metres
    return turn


class Surroundings:
    """The scene's extras under construction."""

    def __init__(self, source: Source, nodes: Nodes, lost: Losses):
        self.source, self.nodes, self.lost = source, nodes, lost
        self.extras: dict = {}
        self.shutter: tuple[float, float] | None = None
        self.lenses: Lenses = {}
        # Cameras by their names in the stage, as nodes may get others.
        self.cameras: dict[str, int] = {}
        self._has_dome = False

    def read(self, prim: Usd.Prim) -> tuple[dict[str, dict], dict[str, tuple[np.ndarray, np.ndarray]]]:
        """Custom properties, as of `read_properties`; those of the scene are kept apart."""
        found, carried = read_properties(prim, self.source)
        for name in OF_SCENE:
            if name in found and name not in self.extras:
                self.extras[name] = found.pop(name)
                picture = prim.GetAttribute(f"{SPACE}{name}:image")
                if isinstance(asset := picture.Get() if picture else None, Sdf.AssetPath):
                    self.extras[name]["image"] = picture_uri(asset, str(picture.GetPath()))
                for field_name, (codes, rows) in carried.items():
                    if field_name.startswith(f"{name}."):
                        self.nodes.carry(None, field_name, codes, rows)
        return found, carried

    def read_camera(self, prim: Usd.Prim, node: int, stops: float | None, shutter: tuple[float, float] | None) -> None:
        """Keeps what a camera says of all pictures."""
        self.lenses[str(prim.GetPath())] = self.nodes.of(node)["name"], stops
        self.shutter = self.shutter or shutter

    def read_sky(self, light: Usd.Prim) -> None:
        """Makes a DomeLight the sky."""
        if ENVIRONMENT in self.extras:
            # The renderer's own properties override any dome.
            if self._has_dome:
                self.lost.add("usd-dome-second", light, "a second DomeLight is not carried: there is one sky")
            return
        hidden = seen(up_to(light, light.GetStage().GetPseudoRoot()), self.source)
        if hidden is not None and hidden[1].any():
            what = "a sky that is seen for a while is seen as it is at first"
            self.lost.add("usd-dome-animated", light, what)
        if hidden is not None and not hidden[1][0]:
            return
        self._has_dome = True
        self.extras[ENVIRONMENT] = read_dome(light, self.source, ours_from_stage(self.source), self.lost)

    def finish(self, options: ImportOptions) -> None:
        """Adds frames, settings, shutter and exposure."""
        source = self.source
        first, last = source.frames
        sunfleck = self.extras.setdefault("sunfleck", {})
        sunfleck.update(
            version=1, fps=source.fps.numerator, fps_base=source.fps.denominator, frame_start=first, frame_end=last,
            light_units="spec",
        )  # fmt: skip
        take_render_settings(sunfleck, source, options, self.lenses, self.lost)
        if sunfleck.get("camera") in self.cameras:
            sunfleck["camera"] = self.nodes.of(self.cameras[sunfleck["camera"]])["name"]
        if self.shutter is not None and "shutter" not in sunfleck:
            opening, closing = self.shutter
            sunfleck.update(shutter=closing - opening, shutter_offset=opening)
        take_exposure(sunfleck, self.lenses)
