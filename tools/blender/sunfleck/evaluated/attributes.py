"""Mesh attributes by corner, by the names that materials use.

In go evaluated meshes, out come rows of one to four numbers a corner: what Blender's type has. Invariant:
colours are linear; missing attributes are opaque black, as in Cycles.
"""

from collections.abc import Mapping
from typing import Any

import bpy
import numpy
from numpy.typing import NDArray

Array = NDArray[Any]

# By Blender's type: the field of its data, the number of components, and their meaning.
TYPES = {
    "FLOAT": ("value", 1, "f4"), "INT": ("value", 1, "i4"), "INT8": ("value", 1, "i1"), "BOOLEAN": ("value", 1, "?"),
    "FLOAT2": ("vector", 2, "f4"), "FLOAT_VECTOR": ("vector", 3, "f4"), "FLOAT_COLOR": ("color", 4, "f4"),
    "BYTE_COLOR": ("color", 4, "f4"), "QUATERNION": ("value", 4, "f4"), "FLOAT4": ("vector", 4, "f4"),
}
# Blender's types for new attributes.
MADE = {1: ("FLOAT", "value"), 2: ("FLOAT2", "vector"), 3: ("FLOAT_VECTOR", "vector"), 4: ("FLOAT_COLOR", "color")}
# Attribute name of Blender's generated coordinates.
GENERATED = "sunfleck generated"
NO_GROUPS: Mapping[str, int] = {}
MISSING = (0.0, 0.0, 0.0, 1.0)


def of_corners(mesh: bpy.types.Mesh, name: str, groups: Mapping[str, int] = NO_GROUPS) -> Array:
    """Values by corner. The empty name is the render colour attribute. `groups` are vertex groups by name,
    whose weights are attributes."""
    if name == GENERATED:
        return generated(mesh)[numbers(mesh.loops, "vertex_index", len(mesh.loops), "i4")]
    name = name or mesh.attributes.default_color_name
    if name in groups and name not in mesh.attributes:
        return weights(mesh, groups[name])[numbers(mesh.loops, "vertex_index", len(mesh.loops), "i4")]
    values = values_of(mesh.attributes.get(name) if name else None)
    count = len(mesh.loops)
    if values is None:
        return numpy.tile(numpy.array(MISSING, "f4"), (count, 1))
    domain = mesh.attributes[name].domain
    if domain == "EDGE":
        values = of_vertices(mesh, values)
    if domain in {"POINT", "EDGE"}:
        return values[numbers(mesh.loops, "vertex_index", count, "i4")]
    if domain == "FACE":
        return numpy.repeat(values, numbers(mesh.polygons, "loop_total", len(mesh.polygons), "i4"), axis=0)
    return values


def generated(mesh: bpy.types.Mesh) -> Array:
    """Generated coordinates, 0 to 1 in the mesh's texture space, of each undeformed vertex."""
    size, middle = (numpy.array(of, "f4") for of in (mesh.texspace_size, mesh.texspace_location))
    scale = numpy.divide(0.5, size, out=numpy.zeros(3, "f4"), where=size != 0.0)
    found: Array = 0.5 + scale * (numbers(mesh.vertices, "undeformed_co", (len(mesh.vertices), 3), "f4") - middle)
    return found


def of_vertices(mesh: bpy.types.Mesh, of_edges: Array) -> Array:
    """Means over the edges at each vertex, as in Cycles."""
    ends = numbers(mesh.edges, "vertices", (len(mesh.edges), 2), "i4")
    sums = numpy.zeros((len(mesh.vertices), of_edges.shape[1]), "f4")
    numpy.add.at(sums, ends, of_edges[:, None])
    counts = numpy.bincount(ends.ravel(), minlength=len(sums))
    means: Array = (sums / numpy.maximum(counts, 1)[:, None]).astype("f4")
    return means


def weights(mesh: bpy.types.Mesh, group: int) -> Array:
    """Weight of each vertex in a group; 0 outside it."""
    found = (next((one.weight for one in vertex.groups if one.group == group), 0.0) for vertex in mesh.vertices)
    return numpy.fromiter(found, "f4", len(mesh.vertices))[:, None]


def values_of(attribute: bpy.types.Attribute | None) -> Array | None:
    """Rows of numbers; None for types that Cycles does not support."""
    if attribute is None or attribute.data_type not in TYPES:
        return None
    field, width, kind = TYPES[attribute.data_type]
    return numbers(attribute.data, field, (len(attribute.data), width), kind).astype("f4")


def uv_of_corners(mesh: bpy.types.Mesh, name: str) -> Array:
    """Texture coordinates that nodes stored as another type than a UV map."""
    found = of_corners(mesh, name)
    return numpy.pad(found, ((0, 0), (0, max(0, 2 - found.shape[1]))))[:, :2]


def four(values: Array) -> Array:
    """Values as colours: a number is grey."""
    if values.shape[1] == 1:
        values = values.repeat(3, axis=1)
    missing = numpy.tile(numpy.array(MISSING, "f4"), (len(values), 1))
    return numpy.concatenate([values, missing[:, values.shape[1] :]], axis=1)


def numbers(owner: bpy.types.bpy_prop_collection, name: str, shape: int | tuple[int, ...], kind: str) -> Array:
    """A property of all elements of a collection."""
    found: Array = numpy.empty(shape, kind)
    owner.foreach_get(name, found.ravel())
    return found
