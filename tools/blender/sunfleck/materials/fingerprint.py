"""Fingerprint of a node tree, which changes whenever its result may.

In go a tree and a frame, out come bytes. Invariant: they cover all settings of nodes, sockets, ramps, curves, links,
groups and images.
"""

from collections.abc import Iterator
from typing import Any

import bpy

from ..evaluated.geometry import digest
from ..keys import moves
from .images import texels_of

PASSED_OVER = {
    "rna_type", "location", "location_absolute", "width", "height", "width_hidden", "dimensions", "select", "color", "use_custom_color",
    "show_options", "show_preview", "show_texture", "hide", "parent", "internal_links", "inputs", "outputs", "warning_propagation", "name",
    "image_user", "color_mapping", "color_tag", "debug_zone_body_lazy_function_graph", "debug_zone_lazy_function_graph",
}


def of_tree(tree: bpy.types.NodeTree, frame: float, seen: tuple[bpy.types.NodeTree, ...] = ()) -> bytes:
    names = {node.name: number for number, node in enumerate(tree.nodes)}
    told = [(node.bl_idname, [*settings(node, frame, (*seen, tree))], [*values(node, frame)]) for node in tree.nodes]
    links = sorted(
        (names[link.from_node.name], link.from_socket.identifier, names[link.to_node.name], link.to_socket.identifier, link.is_muted)
        for link in tree.links
    )
    return repr((told, links)).encode()


def settings(node: bpy.types.Node, frame: float, seen: tuple[bpy.types.NodeTree, ...]) -> Iterator[tuple[str, Any]]:
    """Settings of a node."""
    for prop in node.bl_rna.properties:
        if prop.identifier in PASSED_OVER or prop.identifier.startswith("bl_"):
            continue
        yield prop.identifier, told(getattr(node, prop.identifier), frame, seen)


def told(value: Any, frame: float, seen: tuple[bpy.types.NodeTree, ...]) -> Any:
    if isinstance(value, (bool, int, float, str, type(None))):
        return value
    if isinstance(value, bpy.types.Image):
        return of_image(value)
    if isinstance(value, bpy.types.NodeTree):
        return "again" if value in seen else of_tree(value, frame, seen)
    if isinstance(value, bpy.types.ColorRamp):
        stops = [(stop.position, *stop.color) for stop in value.elements]
        return stops, value.interpolation, value.color_mode, value.hue_interpolation
    if isinstance(value, bpy.types.CurveMapping):
        points = [[(*point.location, point.handle_type) for point in curve.points] for curve in value.curves]
        return points, value.extend, value.tone, *value.black_level, *value.white_level
    if isinstance(value, bpy.types.TexMapping):
        return [*value.translation, *value.rotation, *value.scale, value.mapping_x, value.mapping_y, value.mapping_z, value.vector_type]
    if isinstance(value, bpy.types.Object):
        # In a render of a sequence, Blender leaves placements as they were before it.
        return value.name_full, [tuple(row) for row in value.matrix_world], frame if moves(value) else None
    if isinstance(value, bpy.types.ID):
        return value.name_full
    return tuple(value) if hasattr(value, "__len__") and not hasattr(value, "bl_rna") else None


def values(node: bpy.types.Node, frame: float) -> Iterator[tuple[str, Any]]:
    for socket in node.inputs:
        value: Any = getattr(socket, "default_value", None)
        yield (
            socket.identifier,
            tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else told(value, frame, ()),
        )
    if node.type in {"RGB", "VALUE"}:
        value = node.outputs[0].default_value
        yield "value", tuple(value) if hasattr(value, "__len__") else value


def of_image(image: bpy.types.Image) -> tuple[str, ...]:
    pixels = texels_of(image) if image.channels and all(image.size) else b""
    return digest(pixels).hex(), image.colorspace_settings.name, image.alpha_mode, image.source, str(bool(image.packed_file))
