"""Materials that change: numbers of each frame, as pointers of the file.

In go materials as the graph has them in each frame, out come channels. Invariant: what changes and has no pointer is
known (`is_told`).
"""

import numpy

from .. import extras, keys
from . import closures, principled
from .sources import NotSimple
from .written import of_surface, shines

# Of animated numbers: pointers behind the material's, or none.
POINTERS = {
    "base": "pbrMetallicRoughness/baseColorFactor", "metallic": "pbrMetallicRoughness/metallicFactor",
    "roughness": "pbrMetallicRoughness/roughnessFactor", "emission": "emissiveFactor",
    "emission_strength": "extensions/KHR_materials_emissive_strength/emissiveStrength", "normal_scale": "normalTexture/scale",
}


class Changes:
    """Of materials that are keyed or driven; what they emit is multiplied by the exposure."""

    def __init__(self, exposure):
        self.exposure, self.watched, self.tracks = exposure, set(), {}
        # What of each has no pointer, and materials of which it changes.
        self.still, self.moved = {}, set()
        # Those that are glossy in some frame.
        self.glossy = set()

    def start(self, document, clock, shutter):
        self.document, self.clock, self.shutter = document, clock, shutter

    def watch(self, materials):
        """Those that are keyed or driven are looked at in every frame."""
        self.watched = {material for material in materials if keys.changes(material)}

    def see(self, graph, frame):
        for material in self.watched:
            try:
                link = principled.surface_link(material.evaluated_get(graph))
                surface = closures.read(link) if link else None
            except NotSimple:
                surface = None
            if surface:
                numbers = of_surface(surface, self.exposure)
                self.glossy |= {material} if shines(surface) else set()
                still = what_stays(surface), extras.of_material(material.evaluated_get(graph))
                if self.still.setdefault(material, still) != still:
                    self.moved.add(material)
                self.tracks.setdefault(material, []).append((frame, numbers))

    def animate(self, material, number, said):
        """Pointers to every number of it that changes."""
        track = self.tracks.get(material)
        if track is None:
            return
        changed = {name for name in POINTERS if any(numbers[name] != track[0][1][name] for _, numbers in track)}
        if changed & {"emission", "emission_strength"}:
            changed |= {"emission", "emission_strength"}
            # A pointer needs something to point at.
            said.setdefault("emissiveFactor", track[0][1]["emission"])
            strength = {"emissiveStrength": max(track[0][1]["emission_strength"], 0.0)}
            said.setdefault("extensions", {}).setdefault("KHR_materials_emissive_strength", strength)
            self.document.extensions.add("KHR_materials_emissive_strength")
        if any(numbers["base"][3] < 1.0 for _, numbers in track):
            # The first frame may let nothing through.
            said.setdefault("alphaMode", "BLEND")
        frames = numpy.array([frame for frame, _ in track], float)
        # While the shutter is open Cycles has materials as they are at the frame.
        way = "STEP" if self.shutter.length else "LINEAR"
        times = self.clock.seconds(frames + self.shutter.switch if self.shutter.length else frames)
        for name in sorted(changed):
            values = numpy.array([numbers[name] for _, numbers in track], float).reshape(len(track), -1)
            self.document.pointer_channel(f"/materials/{number}/{POINTERS[name]}", times, values, way)

    def is_told(self, material, is_baked):
        """Whether the file has all that changes of it."""
        is_seen = material in self.tracks and not is_baked
        return material not in self.moved and (is_seen or material not in self.watched)


def what_stays(surface):
    """Numbers of a surface that no pointer changes, and where its pictures lie."""
    numbers = {name: source.factor for name, source in surface.sources.items() if name not in POINTERS}
    return numbers, [picture.place() for picture in surface.pictures()]
