"""Materials of volumes: coefficients and grids of fog.

In go volumes, out come custom properties of fog. Invariant: features of Cycles that sunfleck lacks are
reported: as `NotFog` if nothing is left, else as losses.
"""

from dataclasses import dataclass, field, replace

import numpy

from . import fog
from .materials import links, principled, sockets
from .materials.sources import NotSimple


class NotFog(Exception):
    """Reason why a volume is not rendered."""


@dataclass
class Glow:
    """Emission where a grid is 1, per unit of length."""

    color: numpy.ndarray
    grid: str

    def said(self, share):
        return {"emission_grid": self.grid, "emission": (share * self.color).tolist()}


@dataclass
class Look:
    """Coefficients where a grid is 1, in Blender's units of the object."""

    coefficients: fog.Coefficients
    grid: str
    # Name of the grid of colours that multiply its own.
    colors: str = ""
    glow: Glow | None = None
    # Losses, in words.
    lost: list = field(default_factory=list)

    def fog(self, thing, matrix):
        """Custom properties of an evaluated object where it stands, without the file."""
        share = scale(thing, matrix)
        found = {**fog.said(self.coefficients.times(share)), "grid": self.grid}
        if self.colors:
            found["albedo_grid"] = self.colors
        return found | self.glow.said(share) if self.glow else found

    def within(self, kinds):
        """Look with only the grids in a file, of these kinds by name; the losses are added."""
        glow, colors, lost = self.glow, self.colors, list(self.lost)
        if glow and kinds.get(glow.grid) != "FLOAT":
            # A missing grid has no emission.
            if glow.grid in kinds:
                lost.append(LIGHT)
            glow = None
        if colors and kinds.get(colors) != "VECTOR_FLOAT":
            if colors in kinds:
                lost.append(f"its colours by the grid `{colors}`")
            colors = ""
        return replace(self, glow=glow, colors=colors, lost=lost)


LIGHT = "the light that it gives off"


def look(thing):
    """Look of an object, or of a volume that nodes made of one."""
    material = next((slot.material for slot in thing.material_slots), None)
    if material is None:
        # As in Cycles: a new Principled Volume.
        return Look(fog.Coefficients(numpy.full(3, 0.5), numpy.full(3, 0.5)), "density")
    output = principled.output_of(material.node_tree) if material.node_tree else None
    link = output and links.link_to(output.inputs["Volume"])
    if not link:
        raise NotFog(f"its material `{material.name}` has no volume")
    try:
        found = Reader()
        found.read(link)
        return found.look(link)
    except NotSimple as problem:
        node = problem.args[0]
        raise NotFog(f"of its material `{material.name}` the node `{node.name}` is not read") from problem


class Reader:
    """Reads shaders that are added."""

    def __init__(self):
        # Coefficients, each with the name of the grid that multiplies it.
        self.parts, self.glows, self.colors, self.lost = [], [], "", []

    def look(self, link):
        grids = {grid for _, grid in self.parts}
        if len(grids) != 1 or not (grid := grids.pop()):
            raise NotSimple(link.from_node)
        if len(self.glows) > 1:
            self.lost.append(LIGHT)
        if self.colors and len(self.parts) > 1:
            self.lost.append(f"its colours by the grid `{self.colors}`")
            self.colors = ""
        coefficients = fog.total(link.from_node, [part for part, _ in self.parts])
        return Look(coefficients, grid, self.colors, self.glows[0] if self.glows else None, self.lost)

    def read(self, link):
        node = link.from_node
        if node.mute or getattr(node, "phase", "HENYEY_GREENSTEIN") != "HENYEY_GREENSTEIN":
            raise NotSimple(node)
        if node.type == "EMISSION":
            self.shine(node, "Strength", "Color")
        elif node.type == "ADD_SHADER":
            for socket in node.inputs:
                if one := links.link_to(socket):
                    self.read(one)
        elif node.type == "PRINCIPLED_VOLUME":
            self.read_principled(node)
        elif node.type in {"VOLUME_SCATTER", "VOLUME_ABSORPTION"}:
            density, grid = factor(node.inputs["Density"])
            self.parts.append((fog.READERS[node.type](node, density), grid))
        else:
            raise NotSimple(node)

    def read_principled(self, node):
        named = {name: node.inputs[f"{name} Attribute"] for name in ("Density", "Color")}
        if any(links.link_to(socket) for socket in named.values()):
            raise NotSimple(node)
        self.shine(node, "Emission Strength", "Emission Color")
        if links.link_to(node.inputs["Blackbody Intensity"]) or fog.number(node, "Blackbody Intensity") > 0.0:
            self.lost.append(LIGHT)
        self.colors = named["Color"].default_value
        if self.colors and fog.value(node, "Absorption Color").any():
            self.lost.append(f"its colours by the grid `{self.colors}`")
            self.colors = ""
        grid = named["Density"].default_value
        density, grid = (fog.number(node, "Density"), grid) if grid else factor(node.inputs["Density"])
        self.parts.append((fog.principled_numbers(node, density), grid))

    def shine(self, node, strength, color):
        """Emission by a grid; without one it is uniform over all voxels."""
        try:
            (number, grid), light = factor(node.inputs[strength]), fog.value(node, color)
        except NotSimple:
            number, grid, light = 1.0, "", numpy.ones(3)
        if grid and (number * light).any():
            self.glows.append(Glow(number * light, grid))
        elif (number * light).any():
            self.lost.append(LIGHT)


def factor(socket):
    """A number, and the name of the grid that it multiplies, "" without one."""
    link = links.link_to(socket)
    node = link.from_node if link else None
    if node is not None and not node.mute:
        if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY" and link.from_socket.name != "Alpha":
            return 1.0, node.attribute_name
        if node.type == "VOLUME_INFO" and link.from_socket.name == "Density":
            return 1.0, "density"
        if node.type == "MATH" and node.operation == "MULTIPLY" and not node.use_clamp:
            (first, grid), (second, other) = (factor(socket) for socket in list(node.inputs)[:2])
            if grid and other:
                raise NotSimple(node)
            return max(0.0, first * second), grid or other
    source = sockets.of(socket)
    if not source.is_constant():
        raise NotSimple(node)
    return source.number(), ""


def scale(thing, matrix):
    """Blender keeps a volume's opacity when its object is scaled, by default."""
    if thing.data.render.space != "OBJECT":
        return 1.0
    across = numpy.array(matrix, float)[:3, :3] @ numpy.full(3, 3.0 ** -0.5)
    return 1.0 / max(1e-12, float(numpy.linalg.norm(across)))


def check(thing):
    """Reason why a volume object is not rendered, from its settings; None if it is rendered, or that is
    unknown."""
    if not thing.data.filepath and not thing.modifiers:
        return "it has no file"
    try:
        look(thing)
    except NotFog as problem:
        return str(problem)
    return None
