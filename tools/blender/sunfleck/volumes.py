"""What a volume's material makes of its grids.

In go volumes, out come custom properties of fog. Invariant: what Cycles would show and sunfleck does not is
told: as `NotFog` where nothing is left of it, else among what is lost.
"""

from dataclasses import dataclass, field

import numpy

from . import fog
from .materials import principled, sockets
from .materials.sockets import NotSimple


class NotFog(Exception):
    """Why a volume is not rendered."""


@dataclass
class Look:
    """What is where a grid is 1, by Blender's units of the object."""

    coefficients: fog.Coefficients
    grid: str
    # What else the material shows, in words.
    lost: list = field(default_factory=list)

    def fog(self, thing):
        """Custom properties of an evaluated object, but for the file."""
        return {**fog.said(self.coefficients.times(scale(thing))), "grid": self.grid}


def look(thing):
    """Of an object, or of a volume that nodes made of one."""
    material = next((slot.material for slot in thing.material_slots), None)
    if material is None:
        # As Cycles has it: a Principled Volume as it is new.
        return Look(fog.Coefficients(numpy.full(3, 0.5), numpy.full(3, 0.5)), "density")
    output = principled.output_of(material.node_tree) if material.node_tree else None
    link = output and sockets.link_to(output.inputs["Volume"])
    if not link:
        raise NotFog(f"its material `{material.name}` has no volume")
    try:
        lost = []
        parts = read(link, lost)
        return Look(fog.total(link.from_node, [part for part, _ in parts]), only_grid(link, parts), lost)
    except NotSimple as problem:
        node = problem.args[0]
        raise NotFog(f"of its material `{material.name}` the node `{node.name}` is not read") from problem


def only_grid(link, parts):
    grids = {grid for _, grid in parts}
    if len(grids) != 1 or not (grid := grids.pop()):
        raise NotSimple(link.from_node)
    return grid


def read(link, lost):
    """Coefficients, each with the name of the grid that they are multiplied by."""
    node = link.from_node
    if node.mute or getattr(node, "phase", "HENYEY_GREENSTEIN") != "HENYEY_GREENSTEIN":
        raise NotSimple(node)
    if node.type == "EMISSION":
        lost.append("the light that it gives off")
        return []
    if node.type == "ADD_SHADER":
        links = [link for socket in node.inputs if (link := sockets.link_to(socket))]
        return [part for one in links for part in read(one, lost)]
    if node.type == "PRINCIPLED_VOLUME":
        return [of_principled(node, lost)]
    if node.type not in {"VOLUME_SCATTER", "VOLUME_ABSORPTION"}:
        raise NotSimple(node)
    density, grid = factor(node.inputs["Density"])
    return [(fog.READERS[node.type](node, density), grid)]


def of_principled(node, lost):
    names = {name: node.inputs[f"{name} Attribute"] for name in ("Density", "Color")}
    if any(sockets.link_to(socket) for socket in names.values()):
        raise NotSimple(node)
    if any(fog.number(node, name) > 0.0 for name in ("Emission Strength", "Blackbody Intensity")):
        lost.append("the light that it gives off")
    if names["Color"].default_value:
        lost.append(f"its colours by the grid `{names['Color'].default_value}`")
    grid = names["Density"].default_value
    if grid:
        return fog.principled_numbers(node, fog.number(node, "Density")), grid
    density, grid = factor(node.inputs["Density"])
    return fog.principled_numbers(node, density), grid


def factor(socket):
    """A number, and the name of the grid that it multiplies, "" without one."""
    link = sockets.link_to(socket)
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


def scale(thing):
    """Blender keeps a volume as opaque when its object is scaled, unless told otherwise."""
    if thing.data.render.space != "OBJECT":
        return 1.0
    across = numpy.array(thing.matrix_world, float)[:3, :3] @ numpy.full(3, 3.0 ** -0.5)
    return 1.0 / max(1e-12, float(numpy.linalg.norm(across)))


def check(thing):
    """Why a volume object is not rendered, as far as its settings tell; None if it is, or that is not known."""
    if not thing.data.filepath and not thing.modifiers:
        return "it has no file"
    try:
        look(thing)
    except NotFog as problem:
        return str(problem)
    return None
