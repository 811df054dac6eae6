#!/usr/bin/env python3
"""Writes small glTF files into tests/data that break one rule of glTF 2.0 or of an extension each.

    python3 tests/data/make_invalid_gltf.py tests/data

What can be done without what is wrong stands in `lenient/gltf`, what is refused in `invalid/gltf`; a
new file in the latter.

Each is the leaf of make_gltf.py with one thing wrong; tests/library/gltf_invalid.rs tells
what must be said of it.
"""

import base64
import struct
import sys
from pathlib import Path

from make_gltf import (
    F32, INDICES, U8, U16, U32, UVS, File, animated, leaf, textured, uvs_f32, with_normal_map,
)

# One black texel.
BLACK = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNgYGAAAAAEAAH2FzhVAAAAAElFTkSuQmCC"
)
# One triangle as meshoptimizer's vertex codec has it would be longer; a header alone is damaged enough.
NO_STREAM = b"\xa0\0\0\0"


def changed(file: File, path: str, value: object) -> File:
    """The file with the value at a path such as `meshes.0.name` replaced, or taken out if it is None."""
    *parents, last = path.split(".")
    place = file.json
    for key in parents:
        place = place[int(key)] if isinstance(place, list) else place.setdefault(key, {})
    if isinstance(place, list):
        place[int(last)] = value
    elif value is None:
        del place[last]
    else:
        place[last] = value
    return file


def draco(**extension: object) -> File:
    """The leaf's primitive said to be compressed with Draco, which it is not."""
    file = leaf()
    file.use("KHR_draco_mesh_compression", required=True)
    view = file.view(b"DRACO\2\2\1\1\0\0" + bytes(range(40)))
    attributes = {"POSITION": 0}
    file.primitive["extensions"] = {
        "KHR_draco_mesh_compression": {"bufferView": view, "attributes": attributes} | extension
    }
    return file


def meshopt(**extension: object) -> File:
    """The positions' view said to be compressed with meshopt, which it is not."""
    file = leaf()
    file.use("EXT_meshopt_compression", required=True)
    view = file.view(NO_STREAM)
    source = file.json["bufferViews"][view]
    file.json["bufferViews"][0]["extensions"] = {
        "EXT_meshopt_compression": {"buffer": 0, "byteOffset": source["byteOffset"], "byteLength": len(NO_STREAM),
                                    "byteStride": 12, "count": 4, "mode": "ATTRIBUTES"} | extension
    }
    return file


def with_uvs(values: list, component: int, shape: str) -> File:
    """A textured leaf with texture coordinates of any kind."""
    return textured(lambda file: file.accessor(values, component, shape))


def with_tangents(values: list, component: int = F32, shape: str = "VEC4") -> File:
    """A leaf with a normal map and tangents of any kind."""
    file = with_normal_map(True)
    file.primitive["attributes"]["TANGENT"] = file.accessor(values, component, shape)
    return file


def webp(data: bytes) -> File:
    """A leaf whose texture is a WebP image alone."""
    file = textured(uvs_f32)
    file.use("EXT_texture_webp", required=True)
    file.json["images"] = [{"bufferView": file.view(data), "mimeType": "image/webp"}]
    file.json["textures"] = [{"extensions": {"EXT_texture_webp": {"source": 0}}}]
    return file


def indexed(values: list, component: int = U16) -> File:
    """The leaf with other indices."""
    file = leaf(indices=False)
    file.primitive["indices"] = file.accessor(values, component)
    return file


def on_the_sun(**fields: object) -> File:
    """The leaf under a sun with a disc and this on it."""
    file = leaf()
    file.json["nodes"][2]["extras"] = {"sunfleck_light": {"angle": 0.1} | fields}
    return file


def pictured_suns(count: int) -> File:
    """The leaf under so many suns with darker limbs."""
    file = on_the_sun(limb_darkening=0.5)
    nodes = file.json["nodes"]
    nodes += [nodes[2] | {"name": f"sun {number}"} for number in range(1, count)]
    file.json["scenes"][0]["nodes"] = list(range(len(nodes)))
    return file


def swinging_fractal(field: str) -> File:
    """The leaf under a fractal whose constant an empty carries to 3."""
    file = on_the_sun(fractal={"real": 0.1, "imaginary": 0.2})
    control = {"sunfleck_ctl": {"target": f"sun.sunfleck_light.{field}", "channel": "translation.x"}}
    file.json["nodes"].append({"name": "ctl", "translation": [3, 0, 0], "extras": control})
    file.json["scenes"][0]["nodes"].append(3)
    return file


def requiring(extension: str) -> File:
    """The leaf, which cannot be read without an extension, so it says."""
    file = leaf()
    file.use(extension, required=True)
    return file


def data_uri(data: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(data).decode()


def chunk(kind: int, data: bytes) -> bytes:
    return struct.pack("<II", len(data), kind) + data


def glb(*chunks: bytes) -> bytes:
    body = b"".join(chunks)
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942

FILES: dict[str, File] = {
    "accessor_count_negative": changed(leaf(), "accessors.0.count", -1),
    "accessor_without_count": changed(leaf(), "accessors.0.count", None),
    "animation_interpolation_unknown": animated("BEZIER", [(0, 0, 0)] * 2),
    "animation_key_times_of_vectors": changed(animated("LINEAR", [(0, 0, 0)] * 2), "accessors.2.type", "VEC2"),
    "animation_output_of_quaternions": changed(animated("LINEAR", [(0, 0, 0)] * 2), "accessors.3.type", "VEC4"),
    "animation_output_short_of_tangents": animated("CUBICSPLINE", [(0, 0, 0)] * 2),
    "asset_missing": changed(leaf(), "asset", None),
    "base_color_negative": changed(leaf(), "materials.0.pbrMetallicRoughness.baseColorFactor", [-1, 0, 0, 1]),
    "buffer_view_without_length": changed(leaf(), "bufferViews.0.byteLength", None),
    "camera_aspect_zero": changed(leaf(), "cameras.0.perspective.aspectRatio", 0),
    "camera_fov_of_half_a_turn": changed(leaf(), "cameras.0.perspective.yfov", 3.1416),
    "draco_attribute_without_accessor": draco(attributes={"POSITION": 0, "NORMAL": 1}),
    "draco_damaged": draco(),
    "draco_malformed": draco(attributes=7),
    "draco_mode_strip": changed(draco(), "meshes.0.primitives.0.mode", 5),
    "draco_view_missing": draco(bufferView=9),
    "emission_negative": changed(leaf(), "materials.0.emissiveFactor", [0, 0, -1]),
    "image_webp_damaged": webp(b"RIFF\x10\0\0\0WEBPVP8 \4\0\0\0oops"),
    "indices_missing": changed(leaf(), "meshes.0.primitives.0.indices", 9),
    "indices_of_vectors": changed(leaf(), "accessors.1.type", "VEC3"),
    "indices_restart": indexed([0, 1, 2, 65535, 1, 3]),
    "light_color_negative": changed(leaf(), "extensions.KHR_lights_punctual.lights.0.color", [1, -1, 1]),
    "sun_fractal_half_an_iteration": on_the_sun(fractal={"real": 0, "imaginary": 0, "iterations": 99.5}),
    "sun_fractal_incomplete": on_the_sun(fractal={"real": 0}),
    "sun_fractal_of_three": on_the_sun(fractal={"real": 0, "imaginary": 3}),
    "sun_fractal_swings_too_far": swinging_fractal("fractal_real"),
    "sun_image_and_fractal": on_the_sun(image=data_uri(BLACK), fractal={"real": 0, "imaginary": 0}),
    "sun_image_black": on_the_sun(image=data_uri(BLACK)),
    "sun_image_elsewhere": on_the_sun(image="https://example.org/sun.png"),
    "sun_image_is_text": on_the_sun(image=data_uri(b"no image")),
    "sun_limb_above_one": on_the_sun(limb_darkening=1.5),
    "suns_with_too_many_pictures": pictured_suns(17),
    "extension_required_double": requiring("KHR_accessor_float64"),
    "extension_required_glossiness": requiring("KHR_materials_pbrSpecularGlossiness"),
    "extension_required_dds": requiring("MSFT_texture_dds"),
    "extension_required_packing": requiring("MSFT_packing_occlusionRoughnessMetallic"),
    "extension_required_restart": requiring("EXT_mesh_primitive_restart"),
    "extension_required_sky": requiring("EXT_lights_image_based"),
    "extension_required_splats": requiring("KHR_gaussian_splatting"),
    "extension_required_stream": requiring("MPEG_accessor_timed"),
    "extension_required_video": requiring("MPEG_texture_video"),
    "light_type_unknown": changed(leaf(), "extensions.KHR_lights_punctual.lights.0.type", "candle"),
    "meshopt_buffer_missing": meshopt(buffer=3),
    "meshopt_count_huge": meshopt(count=1 << 40),
    "meshopt_damaged": meshopt(),
    "meshopt_filter_unknown": meshopt(filter="BLUR"),
    "meshopt_mode_unknown": meshopt(mode="POINTS"),
    "meshopt_range_beyond_buffer": meshopt(byteLength=100000),
    "mode_unknown": changed(leaf(), "meshes.0.primitives.0.mode", 7),
    "node_child_negative": changed(leaf(), "nodes.0.children", [-1]),
    "node_matrix_short": changed(leaf(), "nodes.0.matrix", [1, 0, 0, 0]),
    "node_matrix_and_parts": changed(changed(leaf(), "nodes.0.matrix", [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
                                     "nodes.0.translation", [1, 0, 0]),
    "roughness_above_one": changed(leaf(), "materials.0.pbrMetallicRoughness.roughnessFactor", 2),
    "scene_node_missing": changed(leaf(), "scenes.0.nodes", [0, 1, 2, 40]),
    "sparse_count_too_many": changed(leaf(), "accessors.0.sparse", {
        "count": 5, "indices": {"bufferView": 0, "componentType": U8}, "values": {"bufferView": 0}}),
    "sparse_indices_float": changed(leaf(), "accessors.0.sparse", {
        "count": 1, "indices": {"bufferView": 0, "componentType": F32}, "values": {"bufferView": 0}}),
    "clearcoat_above_one": changed(leaf(), "materials.0.extensions.KHR_materials_clearcoat", {"clearcoatFactor": 1.5}),
    "clearcoat_normal_texture_missing": changed(
        textured(uvs_f32), "materials.0.extensions.KHR_materials_clearcoat",
        {"clearcoatFactor": 1, "clearcoatNormalTexture": {"index": 3}}),
    "sheen_color_of_two": changed(leaf(), "materials.0.extensions.KHR_materials_sheen", {"sheenColorFactor": [1, 1]}),
    "sheen_roughness_negative": changed(
        leaf(), "materials.0.extensions.KHR_materials_sheen", {"sheenRoughnessFactor": -0.5}),
    "sky_image_and_color": changed(
        leaf(), "scenes.0.extras.sunfleck_env", {"color": [1, 1, 1], "image": "data:image/x-exr;base64,AAAA"}),
    "sky_image_is_none": changed(
        leaf(), "scenes.0.extras.sunfleck_env", {"image": "data:image/x-exr;base64,AAAA"}),
    "sky_image_missing": changed(leaf(), "scenes.0.extras.sunfleck_env", {"image": "nowhere.hdr"}),
    "sky_image_on_the_web": changed(leaf(), "scenes.0.extras.sunfleck_env", {"image": "https://example.org/sky.hdr"}),
    "sky_rotation_text": changed(
        leaf(), "scenes.0.extras.sunfleck_env", {"color": [1, 1, 1], "rotation": "north"}),
    "tangents_fewer": with_tangents([(1, 0, 0, 1)] * 5),
    "tangents_missing": changed(with_normal_map(True), "meshes.0.primitives.0.attributes.TANGENT", 77),
    "tangents_of_three": with_tangents([(1, 0, 0)] * 6, shape="VEC3"),
    "tangents_u8": with_tangents([(1, 0, 0, 1)] * 6, component=U8),
    "texture_coordinates_fewer": with_uvs(UVS[:3], F32, "VEC2"),
    "texture_coordinates_of_three": with_uvs([(0, 0, 0)] * 4, F32, "VEC3"),
    "texture_coordinates_u32": with_uvs([(0, 0)] * 4, U32, "VEC2"),
    "texture_missing": changed(textured(uvs_f32), "materials.0.pbrMetallicRoughness.baseColorTexture.index", 4),
    "texture_sampler_missing": changed(textured(uvs_f32), "textures.0.sampler", 2),
    "texture_without_image": changed(textured(uvs_f32), "textures.0.source", None),
    "triangles_none": indexed(INDICES[:1]),
}

BYTES: dict[str, bytes] = {
    "glb_binary_chunk_first.glb": glb(chunk(BINARY_CHUNK, b"\0" * 8), chunk(JSON_CHUNK, b"{}  ")),
    "glb_without_chunks.glb": glb(),
    "glb_json_empty.glb": glb(chunk(JSON_CHUNK, b"")),
    "json_byte_order_mark.gltf": b"\xef\xbb\xbf" + leaf().finish(),
    "json_is_a_list.gltf": b"[]",
    "json_is_a_number.gltf": b"2.0",
    "json_not_utf8.gltf": leaf().finish().replace(b'"leaf"', b'"l\xffaf"', 1),
    "json_nested_without_end.gltf": b'{"asset": ' + b"[" * 100_000,
}


def main(root: Path) -> None:
    """Writes every file where it stands."""
    files = {f"{name}.gltf": file.finish() for name, file in FILES.items()} | BYTES
    for name, data in files.items():
        lenient = root / "lenient/gltf" / name
        (lenient if lenient.exists() else root / "invalid/gltf" / name).write_bytes(data)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
