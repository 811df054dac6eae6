"""Fog of objects and of the world: from the volume material, else from the panel.

In go objects and settings, out come extinction, albedo and anisotropy. Invariant: a material with more
than constants is not read partly; the panel counts, and the check reports it.
"""

import math
from dataclasses import dataclass

import numpy
from mathutils import Vector

from . import world
from .materials import links, principled, sockets
from .materials.colours import rec709
from .materials.sources import NotSimple


@dataclass
class Coefficients:
    """Per metre, three channels each."""

    scattering: numpy.ndarray
    absorption: numpy.ndarray
    anisotropy: float = 0.0

    def times(self, share):
        return Coefficients(share * self.scattering, share * self.absorption, self.anisotropy)


def numbers(thing):
    """Coefficients as custom properties."""
    found = of_material(thing)
    return of_settings(thing.sunfleck_settings) if found is None else found


def of_settings(own):
    return {"density": own.density, "albedo": list(own.albedo), "anisotropy": own.anisotropy}


def mist(own):
    """Mist as custom properties, along glTF's axes."""
    return {
        "size": own.mist_size, "octaves": own.mist_octaves, "shape": own.mist_shape, "seed": own.mist_seed,
        **{name.removeprefix("mist_"): value for name, value in changing_mist(own).items()},
    }


def changing_mist(own):
    """Parameters of mist that may be keyed."""
    along, across, up = own.mist_wind
    turns = own.mist_evolution_turns
    return {"mist_cover": own.mist_cover, "mist_wind": (along, up, -across), "mist_evolution_turns": turns}


def of_material(thing):
    """Coefficients; None without such a material, or with more than constants."""
    socket = volume_of(thing)
    return socket and numbers_of(socket)


def numbers_of(socket):
    try:
        return said(read(links.link_to(socket) or socket.links[0]))
    except NotSimple:
        return None


def said(found):
    """Custom properties of coefficients."""
    extinction = found.scattering + found.absorption
    albedo = numpy.divide(found.scattering, extinction, out=numpy.zeros(3), where=extinction > 0.0)
    return {
        "density": extinction.tolist(), "albedo": numpy.clip(albedo, 0.0, 1.0).tolist(),
        "anisotropy": min(0.999, max(-0.999, found.anisotropy)),
    }


# Optical depth beyond which nothing is visible: fog of the world ends there.
DEEP = 20.0


def of_world(scene):
    """Fog of the world's volume, in a box around the scene; None if it does not count."""
    socket = world.volume_of(scene)
    found = socket and not scene.sunfleck_settings.use_fog and numbers_of(socket)
    least = min((density for density in found["density"] if density > 0.0), default=0.0) if found else 0.0
    if least == 0.0:
        return None
    farthest = max((thing.matrix_world.translation.length for thing in scene.objects), default=0.0)
    # A small move of the camera does not change the box.
    reach = DEEP / least + 2.0 ** math.ceil(math.log2(1.0 + farthest))
    return {"bounds": [[-reach] * 3, [reach] * 3], **found}


def volume_of(thing):
    """Volume socket of an object's material, if anything is linked to it."""
    for slot in getattr(thing, "material_slots", ()):
        tree = slot.material and slot.material.node_tree
        output = principled.output_of(tree) if tree else None
        if output and output.inputs["Volume"].is_linked:
            return output.inputs["Volume"]
    return None


def is_lost(thing):
    """Whether an object has a volume material that does not count."""
    return volume_of(thing) is not None and of_material(thing) is None


# Optical depth up to the camera's near plane that is too small to be missed.
LEAST_DEPTH = 2e-3


def is_clipped(thing, eye):
    """Whether a camera is inside the fog, and Cycles' clipping removes some of it."""
    within = eye and thing.matrix_world.inverted_safe() @ eye.matrix_world.translation
    return bool(eye) and is_clipped_of(numbers(thing), eye) and max(map(abs, within)) <= 1.0


def is_clipped_of(found, eye):
    """The same for fog with these coefficients."""
    return eye is not None and eye.type == "CAMERA" and eye.data.clip_start * float(numpy.max(found["density"])) > LEAST_DEPTH


# Tolerance of coincidence, relative to the fog's cube.
TOUCHING = 1e-6


def touches(thing, others):
    """Whether a face of mesh fog coincides with a flat object or other fog: Cycles hits either at random."""
    if thing.type != "MESH" or volume_of(thing) is None:
        return False
    into_cube = thing.matrix_world.inverted_safe()
    flat = (other for other in others if other.type == "MESH" and is_flat(other))
    sides = (numpy.abs(numpy.abs(bounds) - 1.0) for _, bounds in fog_within(thing, others))
    return any(side.min() < TOUCHING for side in sides) or any(is_in_side(other, into_cube @ other.matrix_world) for other in flat)


def overlaps(thing, others):
    """Whether it overlaps other fog with another anisotropy or colour."""
    own = numbers(thing)
    is_inside = lambda bounds: (bounds[0] < 1.0 - TOUCHING).all() and (bounds[1] > TOUCHING - 1.0).all()
    return any(is_inside(bounds) and is_otherwise(own, numbers(other)) for other, bounds in fog_within(thing, others))


def is_otherwise(one, other):
    hues = [numpy.multiply(fog["density"], fog["albedo"]) for fog in (one, other)]
    is_of_a_hue = numpy.linalg.norm(numpy.cross(*hues)) <= 1e-3 * numpy.prod([numpy.linalg.norm(hue) for hue in hues])
    return abs(one["anisotropy"] - other["anisotropy"]) > 1e-3 and not is_of_a_hue


def fog_within(thing, others):
    """Other fog cubes that overlap this one, with their bounds in its own axes."""
    into_cube = thing.matrix_world.inverted_safe()
    for other in others:
        if other == thing or other.hide_render or not other.sunfleck_settings.is_fog:
            continue
        place = into_cube @ other.matrix_world
        reach = numpy.abs(numpy.array(place.to_3x3())).sum(axis=1)
        bounds = numpy.array([place.translation - Vector(reach), place.translation + Vector(reach)])
        if (bounds[0] < 1.0 + TOUCHING).all() and (bounds[1] > -1.0 - TOUCHING).all():
            yield other, bounds


def is_flat(thing):
    return not thing.hide_render and min(thing.dimensions) == 0.0 and max(thing.dimensions) > 0.0


def is_in_side(thing, cube_from_thing):
    # Most are far away.
    if all(abs(abs(along) - 1.0) > TOUCHING for along in cube_from_thing @ Vector(thing.bound_box[0])):
        return False
    corners = numpy.array([*thing.bound_box]) @ numpy.array(cube_from_thing.to_3x3()).T + cube_from_thing.translation
    low, high = corners.min(axis=0), corners.max(axis=0)
    is_near = (low < 1.0 + TOUCHING) & (high > -1.0 - TOUCHING)
    is_in_it = numpy.abs(numpy.abs([low, high]) - 1.0).max(axis=0) < TOUCHING
    return bool(is_near.all() and (is_in_it & (high - low < TOUCHING)).any())


def read(link):
    node = link.from_node
    if node.type in {"GROUP", "GROUP_INPUT"} and not node.mute:
        with links.behind(link.from_socket) as socket:
            return input_of(socket)
    reader = READERS.get(node.type)
    if node.mute or reader is None or getattr(node, "phase", "HENYEY_GREENSTEIN") != "HENYEY_GREENSTEIN":
        raise NotSimple(node)
    return reader(node)


def value(node, name):
    source = sockets.of(node.inputs[name])
    if not source.is_constant():
        raise NotSimple(node)
    return numpy.maximum(numpy.array(rec709(source.factor) if node.inputs[name].type == "RGBA" else source.factor), 0.0)


def number(node, name):
    source = sockets.of(node.inputs[name])
    if not source.is_constant():
        raise NotSimple(node)
    return source.number()


def scatter(node, density=None):
    density = number(node, "Density") if density is None else density
    return Coefficients(density * value(node, "Color"), numpy.zeros(3), number(node, "Anisotropy"))


def absorb(node, density=None):
    density = number(node, "Density") if density is None else density
    return Coefficients(numpy.zeros(3), density * numpy.maximum(1.0 - value(node, "Color"), 0.0))


def of_principled(node):
    """Principled Volume: absorption is the unscattered part, times one minus the root of the absorption
    colour. A mesh has no grids."""
    glows = any(number(node, name) > 0.0 for name in ("Emission Strength", "Blackbody Intensity"))
    if glows or node.inputs["Color Attribute"].default_value:
        raise NotSimple(node)
    return principled_numbers(node, number(node, "Density"))


def principled_numbers(node, density):
    color = value(node, "Color")
    kept = 1.0 - numpy.sqrt(value(node, "Absorption Color"))
    absorption = numpy.maximum(1.0 - color, 0.0) * numpy.maximum(kept, 0.0)
    return Coefficients(density * color, density * absorption, number(node, "Anisotropy"))


def of_coefficients(node):
    if value(node, "Emission Coefficients").any():
        raise NotSimple(node)
    scattering, absorption = (value(node, f"{name} Coefficients") for name in ("Scatter", "Absorption"))
    return Coefficients(scattering, absorption, number(node, "Anisotropy"))


def added(node):
    return total(node, [input_of(socket) for socket in node.inputs])


def mixed(node):
    share, first, second = node.inputs
    source = sockets.of(share)
    if not source.is_constant():
        raise NotSimple(node)
    weight = min(1.0, max(0.0, source.number()))
    return total(node, [input_of(first).times(1.0 - weight), input_of(second).times(weight)])


def input_of(socket):
    link = links.link_to(socket)
    return read(link) if link else Coefficients(numpy.zeros(3), numpy.zeros(3))


def total(node, parts):
    """Sum of scattering with one anisotropy, if there is one."""
    ways = {part.anisotropy for part in parts if part.scattering.any()}
    if len(ways) > 1:
        raise NotSimple(node)
    return Coefficients(
        sum(part.scattering for part in parts), sum(part.absorption for part in parts), *(ways or {0.0})
    )


READERS = {
    "VOLUME_SCATTER": scatter, "VOLUME_ABSORPTION": absorb, "PRINCIPLED_VOLUME": of_principled,
    "VOLUME_COEFFICIENTS": of_coefficients, "ADD_SHADER": added, "MIX_SHADER": mixed,
}
