"""Materials of the file by number, one for each of Blender's and each set of names that meshes have for its texture coordinates.

In go materials and the geometries that show them, out come numbers. Invariant: of every material that was asked for there is a
word: exact, or what of it is lost.
"""

import json
from dataclasses import dataclass, field

import numpy

from ..losses import Finding
from . import principled, sockets
from .images import Images
from .principled import WHITE, Surface
from .sockets import NotSimple, Source
from .written import Writer, of_surface

# Of animated numbers: pointers behind the material's, or none.
POINTERS = {
    "base": "pbrMetallicRoughness/baseColorFactor", "metallic": "pbrMetallicRoughness/metallicFactor",
    "roughness": "pbrMetallicRoughness/roughnessFactor", "emission": "emissiveFactor",
    "emission_strength": "extensions/KHR_materials_emissive_strength/emissiveStrength", "normal_scale": "normalTexture/scale",
}
# What a mesh without a material looks like in Cycles, and what a material without a shader does.
DEFAULT = Surface({"base": Source((0.8,) * 3), "specular": Source((0.0,) * 3), "roughness": WHITE})
NOTHING = Surface({"base": Source((0.0,) * 3), "specular": Source((0.0,) * 3), "roughness": WHITE})


@dataclass
class Look:
    """What a material is: a surface, or none where it lets all light through; and what of it is lost."""

    surface: Surface | None
    losses: list = field(default_factory=list)


class Library:
    """Of a document."""

    def __init__(self):
        self.looks, self.numbers, self.tracks, self.changing = {}, {}, {}, set()

    def start(self, document, clock):
        """Materials go into this document from now on, their keys by this clock."""
        self.document, self.clock, self.images = document, clock, Images(document)

    def look(self, material):
        if material not in self.looks:
            self.looks[material] = looked_at(material)
        return self.looks[material]

    def is_seen(self, material):
        return self.look(material).surface is not None

    def attribute(self, material):
        """The colour attribute that a material looks at and its part ("rgb", "rgba" or "a"); None for none."""
        surface = self.look(material).surface
        if surface is None:
            return None
        base, alpha = surface.sources.get("base", WHITE), surface.alpha
        if base.attribute is not None:
            return base.attribute, "rgba" if alpha.attribute == base.attribute else "rgb"
        return (alpha.attribute, "a") if alpha.attribute is not None else None

    def colors_of(self, material):
        """The names of the colour attributes that meshes have to bring."""
        found = self.attribute(material)
        return [] if found is None else [found[0]]

    def color_attribute(self, material, geometry):
        """That attribute, if the mesh has it; else Blender takes black, and here is nothing."""
        found = self.attribute(material)
        return found if found is not None and found[0] in geometry.colors else None

    def number(self, material, geometry):
        """Of the file's material."""
        order = tuple(geometry.uvs)
        key = (material, order)
        if key not in self.numbers:
            self.numbers[key] = self.made(material, order)
        return self.numbers[key]

    def made(self, material, order):
        look = self.look(material)
        writer = Writer(self.document, self.images, lambda name: order.index(name) if name in order else 0)
        said = writer.material(material.name if material else "default", look.surface)
        look.losses = sorted({*look.losses, *writer.losses})
        if material is not None:
            written = custom(material)
            if written:
                said["extras"] = written
        number = self.document.add("materials", said)
        if material in self.changing:
            self.animate(number, said, self.tracks[material])
        return number

    @property
    def seen(self):
        """Names of what was asked for."""
        return {material.name if material else "default" for material, _ in self.numbers}

    def findings(self):
        """A word on every material that is not exact."""
        for material, look in self.looks.items():
            if material is None or look.surface is None:
                continue
            name = f"the material `{material.name}`"
            if look.losses:
                yield Finding("material-lost", name, ", ".join(look.losses))

    # What changes.

    def watch(self, materials):
        """Those that are keyed or driven are looked at in every frame."""
        from .. import check

        self.changing = {material for material in materials if check.changes(material)}

    def see(self, graph, frame):
        for material in self.changing:
            try:
                shader = principled.shader_of(material.evaluated_get(graph))
                numbers = of_surface(principled.read(shader)) if shader else None
            except NotSimple:
                numbers = None
            if numbers:
                self.tracks.setdefault(material, []).append((frame, numbers))

    def animate(self, number, said, track):
        """Pointers to every number that changes."""
        changed = {name for name in POINTERS if any(numbers[name] != track[0][1][name] for _, numbers in track)}
        if changed & {"emission", "emission_strength"}:
            changed |= {"emission", "emission_strength"}
            # A pointer needs something to point at.
            said.setdefault("emissiveFactor", track[0][1]["emission"])
            strength = {"emissiveStrength": max(track[0][1]["emission_strength"], 0.0)}
            said.setdefault("extensions", {}).setdefault("KHR_materials_emissive_strength", strength)
            self.document.extensions.add("KHR_materials_emissive_strength")
        frames = numpy.array([frame for frame, _ in track], float)
        for name in sorted(changed):
            values = numpy.array([numbers[name] for _, numbers in track], float).reshape(len(track), -1)
            self.document.pointer_channel(f"/materials/{number}/{POINTERS[name]}", self.clock.seconds(frames), values)


def looked_at(material):
    if material is None:
        return Look(DEFAULT)
    shader = principled.shader_of(material)
    if shader is None:
        return Look(None if is_volume(material) else NOTHING)
    try:
        return Look(principled.read(shader))
    except NotSimple as more:
        return Look(fallback(material), [f"node-{more.args[0].type}" if more.args and more.args[0] else "node"])


def fallback(material):
    """A grey that is said."""
    return DEFAULT


def is_volume(material):
    output = principled.output_of(material.node_tree) if material.node_tree else None
    return bool(output and sockets.link_to(output.inputs["Volume"]))


def custom(owner):
    """Its custom properties that JSON can hold."""
    found = {}
    for name, value in owner.items():
        value = value.to_dict() if hasattr(value, "to_dict") else value.to_list() if hasattr(value, "to_list") else value
        try:
            found[name] = json.loads(json.dumps(value, allow_nan=False))
        except (TypeError, ValueError):
            continue
    return found
