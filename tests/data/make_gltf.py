#!/usr/bin/env python3
"""Writes the small glTF files of tests/data/valid/gltf/same: one leaf, said in every way
that glTF 2.0 allows.

    python3 tests/data/make_gltf.py tests/data/valid/gltf/same

Each file shows the picture of `plain.gltf`, to the rounding that its numbers bring;
tests/library/gltf_valid.rs renders them all. No library is used: what is written is what the specification
says, not what a library makes of it.
"""

import base64
import copy
import json
import math
import struct
import sys
from collections.abc import Callable
from pathlib import Path

U8, U16, U32, I8, I16, F32 = 5121, 5123, 5125, 5120, 5122, 5126
LETTERS = {U8: "B", U16: "H", U32: "I", I8: "b", I16: "h", F32: "f"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

# Two triangles, a folded leaf; exact in eighths, so that quantised numbers hold them exactly.
POSITIONS = [(-0.5, 0.0, 0.25), (0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.5, 0.0, 0.25)]
INDICES = [0, 1, 2, 2, 1, 3]
UVS = [(0.0, 0.5), (0.5, 0.0), (0.5, 1.0), (1.0, 0.5)]

CASES: dict[str, Callable[[], "File"]] = {}


def case(function: Callable[[], "File"]) -> Callable[[], "File"]:
    """Registers a file under its function's name."""
    CASES[function.__name__] = function
    return function


class File:
    """A glTF file in the making: its JSON, and one binary buffer."""

    def __init__(self) -> None:
        self.binary = bytearray()
        self.json = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [
                {
                    "nodes": [0, 1, 2],
                    "extras": {"sunfleck": {"version": 1, "fps": 24, "frame_start": 1, "frame_end": 2,
                                            "resolution": [32, 18], "light_units": "spec"}},
                }
            ],
            "nodes": [
                {"name": "leaf", "mesh": 0},
                {"name": "camera", "camera": 0, "translation": [0, 0, 4]},
                {"name": "sun", "rotation": [-0.5, 0, 0, math.sqrt(0.75)],
                 "extensions": {"KHR_lights_punctual": {"light": 0}}},
            ],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}],
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 2049.0}]}},
            "materials": [
                {"name": "green", "doubleSided": True,
                 "pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.5, 0.125, 1], "metallicFactor": 0,
                                          "roughnessFactor": 1},
                 "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}
            ],
            "meshes": [{"name": "leaf", "primitives": [{"attributes": {}, "material": 0}]}],
            "accessors": [],
            "bufferViews": [],
        }
        self.use("KHR_materials_specular")

    def use(self, extension: str, required: bool = False) -> None:
        """Lists an extension."""
        self.json["extensionsUsed"].append(extension)
        if required:
            self.json.setdefault("extensionsRequired", []).append(extension)

    @property
    def primitive(self) -> dict:
        """The leaf's only part."""
        return self.json["meshes"][0]["primitives"][0]

    @property
    def material(self) -> dict:
        """The leaf's material."""
        return self.json["materials"][0]

    def view(self, data: bytes, stride: int | None = None) -> int:
        """Appends bytes and gives the index of the view of them."""
        self.binary.extend(b"\0" * (-len(self.binary) % 4))
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if stride is not None:
            view["byteStride"] = stride
        self.binary.extend(data)
        self.json["bufferViews"].append(view)
        return len(self.json["bufferViews"]) - 1

    def add(self, accessor: dict) -> int:
        """Appends an accessor and gives its index."""
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def accessor(
        self,
        values: list,
        component: int = F32,
        shape: str = "SCALAR",
        *,
        stride: int | None = None,
        normalized: bool = False,
    ) -> int:
        """Numbers, packed one element after another or every `stride` bytes."""
        data = bytearray()
        for value in values:
            element = packed(value, component)
            data += element + b"\xcc" * ((stride or len(element)) - len(element))
        accessor = {
            "bufferView": self.view(bytes(data), stride),
            "componentType": component,
            "count": len(values),
            "type": shape,
        }
        if normalized:
            accessor["normalized"] = True
        return self.add(accessor)

    def finish(self, *, uri: str | None = None) -> bytes:
        """The file as `.gltf`, its buffer in a data URI unless another is given."""
        document = copy.deepcopy(self.json)
        for key in [key for key, value in document.items() if value == []]:
            del document[key]
        if self.binary:
            data = "data:application/octet-stream;base64," + base64.b64encode(self.binary).decode()
            document["buffers"] = [{"byteLength": len(self.binary), "uri": uri or data}]
        return json.dumps(document, indent=1).encode()

    def finish_glb(self, *, extra_chunk: bytes = b"", slack: int = 0) -> bytes:
        """The file as `.glb`; the specification allows more chunks after the second."""
        document = copy.deepcopy(self.json)
        document["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        binary = bytes(self.binary) + b"\0" * (-len(self.binary) % 4 + slack)
        chunks = (
            struct.pack("<II", len(text), 0x4E4F534A)
            + text
            + struct.pack("<II", len(binary), 0x004E4942)
            + binary
        )
        chunks += extra_chunk
        return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def packed(value: object, component: int) -> bytes:
    """One element, little-endian."""
    numbers = value if isinstance(value, (tuple, list)) else [value]
    return struct.pack(f"<{len(numbers)}{LETTERS[component]}", *numbers)


def leaf(positions: bool = True, indices: bool = True) -> File:
    """The plain leaf, or what of it a case says in its own way."""
    file = File()
    if positions:
        file.primitive["attributes"]["POSITION"] = file.accessor(POSITIONS, F32, "VEC3")
    if indices:
        file.primitive["indices"] = file.accessor(INDICES, U16)
    return file


# Indices, modes and attributes


@case
def plain() -> File:
    return leaf()


@case
def indices_u8() -> File:
    file = leaf(indices=False)
    file.primitive["indices"] = file.accessor(INDICES, U8)
    return file


@case
def indices_u32() -> File:
    file = leaf(indices=False)
    file.primitive["indices"] = file.accessor(INDICES, U32)
    return file


@case
def indices_none() -> File:
    file = leaf(positions=False, indices=False)
    file.primitive["attributes"]["POSITION"] = file.accessor([POSITIONS[i] for i in INDICES], F32, "VEC3")
    return file


@case
def indices_at_an_offset_into_a_shared_view() -> File:
    file = leaf(indices=False)
    data = struct.pack("<3H", 9, 9, 9) + struct.pack("<6H", *INDICES)
    file.primitive["indices"] = file.add(
        {"bufferView": file.view(data), "byteOffset": 6, "componentType": U16, "count": 6, "type": "SCALAR"}
    )
    return file


@case
def mode_strip() -> File:
    file = leaf(indices=False)
    file.primitive.update({"mode": 5, "indices": file.accessor([0, 1, 2, 3], U8)})
    return file


@case
def mode_fan() -> File:
    file = leaf(indices=False)
    file.primitive.update({"mode": 6, "indices": file.accessor([1, 3, 2, 0], U8)})
    return file


@case
def two_primitives() -> File:
    file = leaf(indices=False)
    position = file.primitive["attributes"]["POSITION"]
    file.json["meshes"][0]["primitives"] = [
        {"attributes": {"POSITION": position}, "indices": file.accessor(half, U16), "material": 0}
        for half in (INDICES[:3], INDICES[3:])
    ]
    return file


@case
def points_and_lines_beside() -> File:
    file = leaf()
    position = file.primitive["attributes"]["POSITION"]
    for mode in range(4):
        file.json["meshes"][0]["primitives"].append({"attributes": {"POSITION": position}, "mode": mode})
    return file


@case
def degenerate_triangles_beside() -> File:
    file = leaf(indices=False)
    file.primitive["indices"] = file.accessor(INDICES + [0, 0, 1, 2, 2, 2], U16)
    return file


@case
def positions_interleaved() -> File:
    file = leaf(positions=False)
    data = b"".join(packed(p, F32) + packed(uv, F32) for p, uv in zip(POSITIONS, UVS))
    view = file.view(data, stride=20)
    common = {"bufferView": view, "componentType": F32, "count": 4}
    file.primitive["attributes"] = {"POSITION": file.add(common | {"type": "VEC3"}),
                                    "TEXCOORD_0": file.add(common | {"type": "VEC2", "byteOffset": 12})}
    return file


@case
def positions_every_252_bytes() -> File:
    file = leaf(positions=False)
    file.primitive["attributes"]["POSITION"] = file.accessor(POSITIONS, F32, "VEC3", stride=252)
    return file


@case
def positions_sparse() -> File:
    file = leaf(positions=False)
    wrong = [POSITIONS[0], (9.0, 9.0, 9.0), POSITIONS[2], (8.0, 8.0, 8.0)]
    accessor = file.accessor(wrong, F32, "VEC3")
    file.json["accessors"][accessor]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": file.view(struct.pack("<2B", 1, 3)), "componentType": U8},
        "values": {"bufferView": file.view(packed(POSITIONS[1], F32) + packed(POSITIONS[3], F32))},
    }
    file.primitive["attributes"]["POSITION"] = accessor
    return file


@case
def positions_sparse_over_zeros() -> File:
    file = leaf(positions=False)
    values = b"".join(packed(p, F32) for p in POSITIONS)
    file.primitive["attributes"]["POSITION"] = file.add({
        "componentType": F32, "count": 4, "type": "VEC3",
        "sparse": {"count": 4,
                   "indices": {"bufferView": file.view(struct.pack("<4I", 0, 1, 2, 3)), "componentType": U32},
                   "values": {"bufferView": file.view(values)}},
    })
    return file


@case
def positions_with_bounds() -> File:
    file = leaf()
    file.json["accessors"][0] |= {"min": [-0.5, -1, 0], "max": [0.5, 1, 0.25], "name": "corners"}
    return file


def quantized(component: int, steps: int, normalized: bool, one: float) -> File:
    """Positions as integers, a node's scale puts them right (KHR_mesh_quantization)."""
    file = leaf(positions=False)
    file.use("KHR_mesh_quantization", required=True)
    whole = [tuple(int(x * steps) for x in p) for p in POSITIONS]
    size = struct.calcsize(LETTERS[component]) * 3
    file.primitive["attributes"]["POSITION"] = file.accessor(
        whole, component, "VEC3", stride=(size + 3) // 4 * 4, normalized=normalized
    )
    file.json["nodes"][0]["scale"] = [one / steps] * 3
    return file


@case
def positions_i8() -> File:
    return quantized(I8, 64, False, 1.0)


@case
def positions_i8_normalized() -> File:
    return quantized(I8, 64, True, 127.0)


@case
def positions_i16() -> File:
    return quantized(I16, 8192, False, 1.0)


@case
def positions_i16_normalized() -> File:
    return quantized(I16, 8192, True, 32767.0)


@case
def positions_u16_shifted() -> File:
    file = leaf(positions=False)
    file.use("KHR_mesh_quantization", required=True)
    whole = [tuple(int((x + 1) * 1024) for x in p) for p in POSITIONS]
    file.primitive["attributes"]["POSITION"] = file.accessor(whole, U16, "VEC3", stride=8)
    file.json["nodes"][0] |= {"scale": [1 / 1024] * 3, "translation": [-1, -1, -1]}
    return file


# Texture coordinates and textures


def textured(uvs: int, info: dict | None = None) -> File:
    """The leaf's colour from an image of one texel, white, times the factor."""
    file = leaf()
    file.primitive["attributes"]["TEXCOORD_0"] = uvs(file) if callable(uvs) else uvs
    white = base64.b64decode(
        "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N70a4AAAAAElFTkSuQmCC")
    file.json["images"] = [{"bufferView": file.view(white), "mimeType": "image/png"}]
    file.json["textures"] = [{"source": 0}]
    file.material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0} | (info or {})
    return file


def uvs_f32(file: File) -> int:
    return file.accessor(UVS, F32, "VEC2")


@case
def texture_png_in_a_view() -> File:
    return textured(uvs_f32)


@case
def texture_png_in_a_data_uri() -> File:
    file = textured(uvs_f32)
    view = file.json["bufferViews"][file.json["images"][0].pop("bufferView")]
    png = bytes(file.binary[view["byteOffset"]:][: view["byteLength"]])
    file.json["images"][0] = {"uri": "data:image/png;base64," + base64.b64encode(png).decode()}
    return file


@case
def texture_coordinates_u8() -> File:
    whole = [tuple(int(x * 254) for x in uv) for uv in UVS]
    return textured(lambda file: file.accessor(whole, U8, "VEC2", stride=4, normalized=True))


@case
def texture_coordinates_u16() -> File:
    whole = [tuple(int(x * 65534) for x in uv) for uv in UVS]
    return textured(lambda file: file.accessor(whole, U16, "VEC2", normalized=True))


@case
def texture_transformed() -> File:
    transform = {"offset": [0.25, -3], "rotation": 1.5, "scale": [2, -7]}
    file = textured(uvs_f32, {"extensions": {"KHR_texture_transform": transform}})
    file.use("KHR_texture_transform", required=True)
    return file


@case
def texture_from_the_second_set() -> File:
    file = textured(uvs_f32, {"texCoord": 1})
    file.primitive["attributes"]["TEXCOORD_1"] = uvs_f32(file)
    return file


@case
def texture_sampler_clamped_and_nearest() -> File:
    file = textured(uvs_f32)
    file.json["samplers"] = [{"wrapS": 33071, "wrapT": 33071, "magFilter": 9728, "minFilter": 9984}]
    file.json["textures"][0]["sampler"] = 0
    return file


@case
def texture_sampler_mirrored() -> File:
    file = textured(uvs_f32)
    file.json["samplers"] = [{"wrapS": 33648, "wrapT": 33648}]
    file.json["textures"][0]["sampler"] = 0
    return file


@case
def texture_plain_beside_webp() -> File:
    file = textured(uvs_f32)
    file.use("EXT_texture_webp")
    file.json["images"].append({"bufferView": file.view(b"RIFF\0\0\0\0WEBP"), "mimeType": "image/webp"})
    file.json["textures"][0]["extensions"] = {"EXT_texture_webp": {"source": 1}}
    return file


@case
def texture_that_nothing_uses_is_damaged() -> File:
    file = leaf()
    file.json["images"] = [{"bufferView": file.view(b"no image"), "mimeType": "image/png"}]
    file.json["textures"] = [{"source": 0}]
    return file


# Materials


@case
def alpha_mask_that_passes() -> File:
    file = leaf()
    file.material.update({"alphaMode": "MASK", "alphaCutoff": 0.75})
    return file


@case
def alpha_ignored_when_opaque() -> File:
    file = leaf()
    file.material.update({"alphaMode": "OPAQUE"})
    file.material["pbrMetallicRoughness"]["baseColorFactor"][3] = 0.25
    return file


@case
def alpha_blend_of_one() -> File:
    file = leaf()
    file.material.update({"alphaMode": "BLEND"})
    return file


@case
def clearcoat_and_sheen_of_none() -> File:
    file = textured(uvs_f32)
    file.use("KHR_materials_clearcoat", required=True)
    file.use("KHR_materials_sheen")
    file.material["extensions"]["KHR_materials_clearcoat"] = {"clearcoatTexture": {"index": 0}}
    file.material["extensions"]["KHR_materials_sheen"] = {
        "sheenRoughnessFactor": 0.5,
        "sheenRoughnessTexture": {"index": 0},
    }
    return file


def with_normal_map(normals: bool) -> File:
    """A normal map that counts nothing; with normals, which are those of the triangles, each has
    its own vertices."""
    file = textured(uvs_f32)
    file.material["normalTexture"] = {"index": 0, "scale": 0}
    if normals:
        attributes = file.primitive["attributes"]
        attributes["POSITION"] = file.accessor([POSITIONS[i] for i in INDICES], F32, "VEC3")
        attributes["TEXCOORD_0"] = file.accessor([UVS[i] for i in INDICES], F32, "VEC2")
        half = math.sqrt(0.2)
        attributes["NORMAL"] = file.accessor(
            [(half, 0, 2 * half)] * 3 + [(-half, 0, 2 * half)] * 3, F32, "VEC3"
        )
        del file.primitive["indices"]
    return file


@case
def normal_map_without_tangents() -> File:
    return with_normal_map(True)


@case
def normal_map_without_normals_or_texture_coordinates() -> File:
    file = with_normal_map(False)
    file.material["normalTexture"]["texCoord"] = 1
    return file


@case
def tangents_without_normals_mean_nothing() -> File:
    file = with_normal_map(False)
    file.primitive["attributes"]["TANGENT"] = file.accessor([(0, 0, 1, 1)] * 4, F32, "VEC4")
    return file


@case
def tangents_i16_normalized() -> File:
    file = with_normal_map(True)
    file.use("KHR_mesh_quantization", required=True)
    file.primitive["attributes"]["TANGENT"] = file.accessor(
        [(0, 32767, 0, -32767)] * 6, I16, "VEC4", normalized=True)
    return file


@case
def tangents_without_length() -> File:
    file = with_normal_map(True)
    file.primitive["attributes"]["TANGENT"] = file.accessor([(0, 0, 0, 0)] * 6, F32, "VEC4")
    return file


@case
def material_unused_with_anything_in_it() -> File:
    file = leaf()
    file.json["materials"].append({"extensions": {"ACME_glitter": {"amount": 3}}, "extras": [1, "two", None]})
    file.use("ACME_glitter")
    return file


@case
def material_unused_of_shares_in_single_precision() -> File:
    file = leaf()
    # Blender holds colours in single precision and properties in double: 0.6 and 0.4 are more than 1.
    shading, shares = {"baseColorFactor": [0.6000000238418579] * 3 + [1]}, {"transmission": [0.4] * 3}
    file.json["materials"].append({"pbrMetallicRoughness": shading, "extras": {"sunfleck_material": shares}})
    return file


@case
def emission_of_strength_zero() -> File:
    file = leaf()
    file.use("KHR_materials_emissive_strength")
    file.material["emissiveFactor"] = [1, 1, 1]
    file.material["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": 0}
    return file


# Nodes and scenes


@case
def matrix_instead_of_parts() -> File:
    file = leaf()
    file.json["nodes"][1].pop("translation")
    file.json["nodes"][1]["matrix"] = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 4, 1]
    return file


@case
def scale_and_its_inverse() -> File:
    file = leaf()
    file.json["nodes"].append({"children": [0], "scale": [0.5, 4, 2]})
    file.json["nodes"][0]["scale"] = [2, 0.25, 0.5]
    file.json["scenes"][0]["nodes"] = [3, 1, 2]
    return file


@case
def mirrored_twice() -> File:
    file = leaf()
    file.json["nodes"].append({"children": [0], "scale": [-1, 1, 1]})
    file.json["nodes"][0]["scale"] = [-1, 1, 1]
    file.json["scenes"][0]["nodes"] = [3, 1, 2]
    return file


@case
def a_hundred_parents() -> File:
    file = leaf()
    top = 0
    for _ in range(100):
        file.json["nodes"].append({"children": [top]})
        top = len(file.json["nodes"]) - 1
    file.json["scenes"][0]["nodes"] = [top, 1, 2]
    return file


@case
def rotation_of_another_length() -> File:
    file = leaf()
    file.json["nodes"][2]["rotation"] = [-0.50001, 0, 0, math.sqrt(0.75) * 1.00002]
    return file


@case
def nodes_without_names() -> File:
    file = leaf()
    for node in file.json["nodes"]:
        del node["name"]
    return file


@case
def nodes_of_one_name() -> File:
    file = leaf()
    for node in file.json["nodes"]:
        node["name"] = "leaf"
    return file


@case
def names_of_every_script() -> File:
    file = leaf()
    file.json["nodes"][0]["name"] = "Bl\u00e4tter \u8449 \U0001f342 \"quoted\" \\ / \t"
    return file


@case
def scene_is_the_second() -> File:
    file = leaf()
    file.json["scenes"].insert(0, {"nodes": []})
    file.json["scenes"][0] = {"name": "empty"}
    file.json["scene"] = 1
    return file


@case
def scene_not_said() -> File:
    file = leaf()
    del file.json["scene"]
    return file


@case
def nodes_of_no_scene_beside() -> File:
    file = leaf()
    file.json["nodes"].append({"mesh": 0, "translation": [0, 0, 1], "name": "elsewhere"})
    return file


# Animations, skins and morph targets that change nothing


def animated(interpolation: str, values: list, path: str = "translation", shape: str = "VEC3") -> File:
    """The leaf, held where it is by two keys."""
    file = leaf()
    channel = {"sampler": 0, "target": {"node": 0, "path": path}}
    sampler = {"input": file.accessor([0.0, 1.0]), "output": file.accessor(values, F32, shape),
               "interpolation": interpolation}
    file.json["animations"] = [{"channels": [channel], "samplers": [sampler]}]
    return file


@case
def animation_linear() -> File:
    return animated("LINEAR", [(0, 0, 0)] * 2)


@case
def animation_step() -> File:
    return animated("STEP", [(0, 0, 0), (7, 7, 7)])


@case
def animation_cubic() -> File:
    return animated("CUBICSPLINE", [(0, 0, 0)] * 6)


@case
def animation_of_rotation() -> File:
    return animated("LINEAR", [(0, 0, 0, 1)] * 2, "rotation", "VEC4")


@case
def animation_of_scale_as_one_key() -> File:
    file = leaf()
    sampler = {"input": file.accessor([0.5]), "output": file.accessor([(1, 1, 1)], F32, "VEC3")}
    file.json["animations"] = [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}],
                                "samplers": [sampler]}]
    return file


@case
def animation_rotation_i16() -> File:
    file = animated("LINEAR", [(0, 0, 0)] * 2)
    output = file.accessor([(0, 0, 0, 32767)] * 2, I16, "VEC4", normalized=True)
    file.json["animations"][0]["channels"][0]["target"]["path"] = "rotation"
    file.json["animations"][0]["samplers"][0]["output"] = output
    return file


@case
def animation_channel_without_a_node() -> File:
    file = animated("LINEAR", [(5, 5, 5)] * 2)
    del file.json["animations"][0]["channels"][0]["target"]["node"]
    return file


@case
def morph_targets_of_no_weight() -> File:
    file = leaf()
    file.primitive["targets"] = [{"POSITION": file.accessor([(1, 1, 1)] * 4, F32, "VEC3")}]
    file.json["meshes"][0]["weights"] = [0]
    return file


@case
def morph_targets_of_no_weight_said_by_the_node() -> File:
    file = morph_targets_of_no_weight()
    file.json["meshes"][0]["weights"] = [1]
    file.json["nodes"][0]["weights"] = [0]
    return file


@case
def skin_at_rest() -> File:
    file = leaf()
    file.primitive["attributes"] |= {
        "JOINTS_0": file.accessor([(0, 0, 0, 0)] * 4, U8, "VEC4"),
        "WEIGHTS_0": file.accessor([(1, 0, 0, 0)] * 4, F32, "VEC4"),
    }
    file.json["nodes"].append({"name": "bone"})
    file.json["scenes"][0]["nodes"].append(3)
    file.json["nodes"][0]["skin"] = 0
    file.json["skins"] = [{"joints": [3]}]
    return file


# Cameras, lights and what else stands in a file


@case
def camera_with_far_plane_and_aspect() -> File:
    file = leaf()
    file.json["cameras"][0]["perspective"] |= {"zfar": 100.0, "aspectRatio": 32 / 18}
    return file


@case
def camera_second_is_orthographic() -> File:
    file = leaf()
    file.json["cameras"].append({"type": "orthographic",
                                 "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 10}})
    file.json["nodes"].append({"name": "flat", "camera": 1})
    file.json["scenes"][0]["nodes"].append(3)
    file.json["scenes"][0]["extras"]["sunfleck"]["camera"] = "camera"
    return file


@case
def light_with_every_default_said() -> File:
    file = leaf()
    file.json["extensions"]["KHR_lights_punctual"]["lights"][0] |= {"name": "", "color": [1, 1, 1]}
    return file


@case
def light_of_no_intensity_beside() -> File:
    file = leaf()
    file.json["extensions"]["KHR_lights_punctual"]["lights"].append({"type": "point", "intensity": 0})
    file.json["nodes"].append({"extensions": {"KHR_lights_punctual": {"light": 1}}})
    file.json["scenes"][0]["nodes"].append(3)
    return file


@case
def light_with_a_picture_and_no_disc() -> File:
    file = leaf()
    picture = {"limb_darkening": 0.5, "picture_rotation": 1, "fractal": {"real": 0, "imaginary": 0.5}}
    file.json["nodes"][2]["extras"] = {"sunfleck_light": {"visible_to_camera": True, **picture}}
    return file


@case
def asset_says_everything() -> File:
    file = leaf()
    file.json["asset"] |= {
        "minVersion": "2.0",
        "generator": "by hand",
        "copyright": "none",
        "extras": {"a": [1]},
    }
    return file


@case
def extensions_required_that_show_nothing() -> File:
    file = leaf()
    for extension in (
        "KHR_xmp_json_ld",
        "EXT_structural_metadata",
        "KHR_node_hoverability",
        "MSFT_lod",
        "OMI_physics_body",
    ):
        file.use(extension, required=True)
    return file


@case
def extensions_unknown_and_not_required() -> File:
    file = leaf()
    file.use("ACME_leaves")
    file.json["extensions"]["ACME_leaves"] = {"deep": {"deeper": [{}]}}
    file.json["nodes"][0]["extensions"] = {"ACME_leaves": 1}
    return file


@case
def fields_unknown() -> File:
    file = leaf()
    file.json["nodes"][0]["colour"] = "green"
    file.json["later"] = {"version": 3}
    return file


@case
def numbers_written_oddly() -> File:
    file = leaf()
    file.json["nodes"][1]["translation"] = [0.0, -0.0, 4.0e0]
    file.json["cameras"][0]["perspective"]["yfov"] = 0.6000000000000000001
    return file


def main(folder: Path) -> None:
    """Writes every case."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in CASES.items():
        (folder / f"{name}.gltf").write_bytes(make().finish())
    plain = leaf()
    extra = struct.pack("<II", 8, 0x58585858) + b"whatever"
    (folder / "binary.glb").write_bytes(plain.finish_glb())
    (folder / "binary_with_a_third_chunk.glb").write_bytes(plain.finish_glb(extra_chunk=extra))
    (folder / "binary_padded.glb").write_bytes(plain.finish_glb(slack=4))
    (folder / "buffer beside (1) ä.bin").write_bytes(plain.binary)
    beside = plain.finish(uri="buffer%20beside%20(1)%20%C3%A4.bin")
    (folder / "buffer_in_a_file.gltf").write_bytes(beside)
    (folder / "compact_json.gltf").write_bytes(
        json.dumps(json.loads(plain.finish()), separators=(",", ":")).encode()
    )


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
