"""glTF file as a scene: moving nodes, render settings and custom properties.

Invariant: times are true seconds; a frame's time is its number over the frame rate.
"""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from .accessors import Accessors
from .container import Container
from .curves import Curve
from .nodes import Node, read_animations, read_nodes
from .values import Value

DEFAULT_FPS, MOST_FRAMES = 24, 100_000


@dataclass(frozen=True)
class Settings:
    """Render settings in the scene's property `sunfleck`."""

    fps: Fraction
    first: int
    last: int
    size: tuple[int, int]
    camera: str
    light_units: str
    shutter: tuple[float, float]
    """Opening and closing of the shutter, in frames from the frame; equal for an instant."""

    @property
    def frames(self) -> range:
        """Range of frames."""
        return range(self.first, self.last + 1)

    def seconds(self, frames: np.ndarray) -> np.ndarray:
        """Times of frames."""
        return np.asarray(frames, float) * (self.fps.denominator / self.fps.numerator)


class Gltf:
    """Parsed glTF file."""

    def __init__(
        self, container: Container, fps: Fraction | None = None, frames: tuple[int, int] | None = None
    ):
        self.container = container
        self.warnings: list[str] = []
        """Losses of the program that wrote the file."""
        self.document = container.document
        self.accessors = Accessors(self.container)
        scenes = self.document.items("scenes")
        number = self.document.member("scene")
        if number is not None:
            self.scene = number.item_of(scenes, "scene")
        else:
            self.scene = scenes[0] if scenes else Value({}, self.document.file, "scenes")
        self.extras = self.scene.extras
        self.nodes = read_nodes(self.document, self.scene)
        read_animations(self.document, self.nodes, self.accessors)
        self._mend_times()
        self.settings = self._settings(fps, frames)
        self.controls = self._controls()
        self._used: set[str] = set()

    def _mend_times(self) -> None:
        """Corrects key times, as Blender multiplies by fps_base in place of dividing."""
        sunfleck = self.extras.group("sunfleck")
        base = sunfleck.number_at("fps_base", 1.0, 1e-6, 1e6)
        if (first := sunfleck.number_at("frame_at_zero", 0.0, -1e7, 1e7)) != 0.0:
            seconds = first * base / sunfleck.number_at("fps", DEFAULT_FPS, 1e-3, 1e6)
            for node in self.nodes:
                node.curves = {path: _later(curve, seconds) for path, curve in node.curves.items()}
                node.weights, node.shown = (
                    curve and _later(curve, seconds) for curve in (node.weights, node.shown)
                )
        generator = self.document.need("asset").text_at("generator")
        if base == 1.0 or "Blender" not in generator or sunfleck.member("fps") is None:
            return
        rate = sunfleck.number_at("fps", DEFAULT_FPS, 1e-6, 1e6)
        for node in self.nodes:
            for path, curve in node.curves.items():
                node.curves[path] = _mended(curve, rate, base)
            if node.weights is not None:
                node.weights = _mended(node.weights, rate, base)

    def _settings(self, fps: Fraction | None, frames: tuple[int, int] | None) -> Settings:
        sunfleck = self.extras.group("sunfleck")
        base = sunfleck.number_at("fps_base", 1.0, 1e-3, 1e6)
        rate = sunfleck.number_at("fps", DEFAULT_FPS, 1e-3, 1e6) / base
        fps = fps or Fraction(rate).limit_denominator(1001)
        first, last = self._keyed_frames(fps)
        first = int(sunfleck.number_at("frame_start", first, -1e7, 1e7))
        last = int(sunfleck.number_at("frame_end", max(first, last), -1e7, 1e7))
        first, last = frames or (first, last)
        if last < first or last - first >= MOST_FRAMES:
            sunfleck.fail(f"frames {first} to {last} are no range of at most {MOST_FRAMES}")
        size = sunfleck.member("resolution")
        width, height = (0, 0) if size is None else (max(1, int(number)) for number in size.numbers(2))
        shutter = sunfleck.number_at("shutter", 0.0, 0.0, 1000.0)
        opening = sunfleck.number_at("shutter_offset", -0.5 * shutter, -1000.0, 1000.0) if shutter else 0.0
        camera, units = sunfleck.text_at("camera"), sunfleck.text_at("light_units", "spec")
        return Settings(fps, first, last, (width, height), camera, units, (opening, opening + shutter))

    def _keyed_frames(self, fps: Fraction) -> tuple[int, int]:
        curves = [curve for node in self.nodes for curve in node.curves.values() if len(curve.times_s) > 1]
        if not curves:
            return 1, 1
        rate = float(fps)
        first = min(float(curve.times_s[0]) for curve in curves)
        last = max(float(curve.times_s[-1]) for curve in curves)
        return round(first * rate), round(last * rate)

    def _controls(self) -> "dict[str, Control]":
        """Animated values in nodes, by their targets."""
        found = {}
        for node in self.nodes:
            control = node.extras.member("sunfleck_ctl")
            if control is None:
                continue
            vector, _, axis = control.text_at("channel").partition(".")
            if vector in ("translation", "scale") and (axis == "" or axis in "xyz"):
                found[control.text_at("target")] = Control(node, vector, "xyz".find(axis) if axis else None)
        return found

    def control(self, owner: str, field: str) -> "Control | None":
        """Control of a field of a property of a node (by its name) or of `scene`, such as
        `sunfleck_light.radius`."""
        target = f"{owner}.{field}"
        self._used.add(target)
        return self.controls.get(target)

    @property
    def unused(self) -> list[str]:
        """Targets of controls that no reader used."""
        return sorted(self.controls.keys() - self._used)


def _later(curve: Curve, seconds: float) -> Curve:
    """Curve delayed by some seconds."""
    times_s = (curve.times_s.astype(np.float64) + seconds).astype(np.float32)
    return Curve(times_s, curve.values, curve.interpolation, curve.turns)


@dataclass(frozen=True)
class Control:
    """Node whose translation or scale carries another object's value."""

    node: Node
    vector: str
    axis: int | None

    @property
    def curve(self) -> Curve | None:
        """Keys of the value."""
        return self.node.curves.get(self.vector)

    def at(self, times_s: np.ndarray) -> np.ndarray:
        """A row of one or three numbers for each time."""
        rows = self.node.parts_at(self.vector, times_s)
        return rows if self.axis is None else rows[:, self.axis : self.axis + 1]


def _mended(curve: Curve, rate: float, base: float) -> Curve:
    frames = curve.times_s.astype(np.float64) * (rate * base)
    whole = np.round(frames)
    frames = np.where(np.abs(frames - whole) <= 1e-6 * np.abs(whole), whole, frames)
    return Curve((frames * (base / rate)).astype(np.float32), curve.values, curve.interpolation, curve.turns)
