"""What a material is baked on: a mesh, or the unit square, in a scene of its own.

In go a material and a geometry, out come pixels. Invariant: afterwards nothing of it is left.
"""

from dataclasses import dataclass

import bpy
import numpy

from ..evaluated.attributes import GENERATED, MADE
from . import dependence
from .images import texels_of

SAMPLES = 4
# So many texels a side have one each, in its middle, unless rays decide what they show.
FINE, BY_RAYS = 2048, {"AMBIENT_OCCLUSION", "BEVEL"}
MARGIN_TEXELS = 4


@dataclass
class Canvas:
    """What is baked on: a geometry, or without one the unit square, in its size in the world where bumps ask for it."""

    geometry: object
    uv: str
    texels: int
    sides_m: tuple = (1.0, 1.0)

    def key(self):
        on_mesh = (self.geometry.known_by(), self.geometry.size) if self.geometry else self.sides_m
        return repr((on_mesh, self.uv, self.texels)).encode()


def size_of(image):
    """Texels of a side, on the unit square: of the largest image within."""
    return min(FINE, max(512, 1 << max(0, int(image) - 1).bit_length()))


def size_on(geometry, has_lines=False):
    """On a mesh: 24 texels for each side of its triangles' cells, thrice as many for lines."""
    columns = int(numpy.ceil(numpy.sqrt(numpy.ceil(len(geometry.triangles) / 2))))
    texels = 3 * 24 if has_lines else 24
    return min(FINE, max(1024 if has_lines else 256, 1 << (texels * columns - 1).bit_length()))


class Stage:
    """A scene of its own with the mesh, or the unit square, and an image to bake into."""

    def __init__(self, material, canvas, frame):
        self.material, self.canvas, self.frame, self.size = material, canvas, frame, canvas.texels

    def __enter__(self):
        self.scene = bpy.data.scenes.new("sunfleck bake")
        self.scene.render.engine = "CYCLES"
        # Films show their picture of the frame at hand.
        whole, part = divmod(self.frame, 1.0)
        self.scene.frame_set(int(whole), subframe=part)
        is_even = self.size == FINE and not any(node.type in BY_RAYS for node in dependence.nodes_of(self.material))
        self.scene.cycles.samples, self.scene.cycles.use_denoising = 1 if is_even else SAMPLES, False
        self.scene.render.bake.margin = MARGIN_TEXELS
        geometry = self.canvas.geometry
        self.mesh = mesh_of(geometry, self.canvas.uv) if geometry else square(self.canvas)
        self.mesh.materials.append(self.material)
        self.thing = bpy.data.objects.new("sunfleck bake", self.mesh)
        self.scene.collection.objects.link(self.thing)
        if geometry:
            self.thing.scale = (geometry.size,) * 3
            if GENERATED in geometry.colors:
                generate(self.thing, geometry)
        self.layer = self.scene.view_layers[0]
        self.layer.objects.active = self.thing
        self.thing.select_set(True, view_layer=self.layer)
        self.image = bpy.data.images.new("sunfleck bake", self.size, self.size, float_buffer=True, alpha=False)
        self.image.colorspace_settings.name = "Non-Color"
        nodes = self.material.node_tree.nodes
        node = nodes.new("ShaderNodeTexImage")
        node.image = self.image
        nodes.active = node
        return self

    def bake(self, kind):
        """(rows from the bottom, columns, 3); normals from -1 to 1."""
        told = {"active_object": self.thing, "object": self.thing, "selected_objects": [self.thing]}
        with bpy.context.temp_override(scene=self.scene, view_layer=self.layer, **told):
            bpy.ops.object.bake(type=kind)
        found = texels_of(self.image)[..., :3].copy()
        return 2.0 * found - 1.0 if kind == "NORMAL" else found

    def __exit__(self, *_):
        bpy.data.objects.remove(self.thing)
        bpy.data.meshes.remove(self.mesh)
        bpy.data.images.remove(self.image)
        bpy.data.scenes.remove(self.scene)


def square(canvas):
    """Of texture coordinates from 0 to 1."""
    mesh = bpy.data.meshes.new("sunfleck bake")
    width, height = canvas.sides_m
    mesh.from_pydata([(0, 0, 0), (width, 0, 0), (width, height, 0), (0, height, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name=canvas.uv or "UVMap").uv.foreach_set("vector", numpy.array([0, 0, 1, 0, 1, 1, 0, 1], "f4"))
    return mesh


def mesh_of(geometry, uv):
    """A geometry as a mesh of Blender, with its coordinates and colours, to be baked into those of a name."""
    mesh = bpy.data.meshes.new("sunfleck bake")
    corners = geometry.triangles.ravel()
    vertices = geometry.corner_vertices[corners]
    mesh.from_pydata(geometry.positions.tolist(), [], vertices.reshape(-1, 3).tolist())
    for name, values in geometry.uvs.items():
        mesh.uv_layers.new(name=name).uv.foreach_set("vector", numpy.ascontiguousarray(values[corners], "f4").ravel())
    first = next((name for name in geometry.uvs if name != uv), uv)
    mesh.uv_layers[first].active_render = True
    mesh.uv_layers.active = mesh.uv_layers[uv]
    for name, values in geometry.colors.items():
        if name in geometry.uvs or name == GENERATED:
            continue
        kind, field = MADE[values.shape[1]]
        attribute = mesh.attributes.new(name or "color", kind, "CORNER")
        attribute.data.foreach_set(field, numpy.ascontiguousarray(values[corners], "f4").ravel())
    if geometry.normals_of != "FACE":
        normals = geometry.normals[corners] if geometry.normals_of == "CORNER" else geometry.normals[vertices]
        mesh.normals_split_custom_set(normals.tolist())
    return mesh


def generate(thing, geometry):
    """Has what is baked on show generated coordinates: those of a mesh before it is bent."""
    corners, mesh = geometry.colors[GENERATED], thing.data
    rest = geometry.positions.copy()
    rest[geometry.corner_vertices] = corners
    mesh.use_auto_texspace, mesh.texspace_location, mesh.texspace_size = False, (0.5,) * 3, (0.5,) * 3
    for part in ("rest", "bent"):
        thing.shape_key_add(name=part)
    key, rows = mesh.shape_keys, numpy.ascontiguousarray(rest, "f4").ravel()
    mesh.vertices.foreach_set("co", rows)
    key.key_blocks["rest"].points.foreach_set("co", rows)
    key.key_blocks["bent"].value = 1.0
