//! Damaged and hostile glTF files. Each is read as far as it makes sense and tells what is lost, or is
//! refused with a message that names the reason. Nothing panics, whatever is changed in a good file. The
//! files under tests/data/invalid/gltf and tests/data/lenient/gltf are tests/data/valid/gltf/leaf.gltf
//! with one thing wrong.

use crate::checkout;
use proptest::prelude::*;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use sunfleck::description::{self, Description, Files, SceneSource, gltf};
use sunfleck::scene;

/// File and what its message must hold.
const REFUSED: &[(&str, &str)] = &[
    (
        "accessor_beyond_view.gltf",
        "accessors[0].count: error: 4 elements, 12 bytes apart, from byte 0 on reach beyond the 36 bytes",
    ),
    ("accessor_count_huge.gltf", "accessors[0].count: error"),
    ("accessor_count_huge_without_view.gltf", "far more than a file of this size holds"),
    ("accessor_empty.gltf", "accessors[0].count: error: the accessor is empty"),
    ("accessor_missing.gltf", "attributes.POSITION: error: accessor 99 does not exist"),
    ("accessor_offset_huge.gltf", "accessors[0].count: error"),
    ("buffer_file_missing.gltf", "nowhere.bin: error: cannot be read"),
    ("buffer_missing.gltf", "bufferViews[0].buffer: error: buffer 7 does not exist"),
    ("buffer_uri_damaged.gltf", "buffers[0].uri: error: the data URI is damaged"),
    ("buffer_uri_on_the_web.gltf", "is not a file beside this one"),
    ("camera_fov_zero.gltf", "there is no camera `camera`"),
    ("camera_missing.gltf", "there is no camera `camera`"),
    ("camera_named_but_missing.gltf", "there is no camera `other`"),
    ("camera_of_no_kind.gltf", "there is no camera `camera`"),
    ("camera_orthographic_flat.gltf", "there is no camera `camera`"),
    ("camera_shift_huge.gltf", "sunfleck_camera.shift: error: the lens is shifted by [0.0, 1000000.0]"),
    ("component_type_of_indices.gltf", "indices cannot be of component type 5126"),
    (
        "component_type_unknown.gltf",
        "accessors[0].componentType: error: positions cannot be of component type 5130",
    ),
    (
        "sky_image_and_color.gltf",
        "scenes[0].extras.sunfleck_env.image: error: this is not an image in a format that is read",
    ),
    (
        "sky_image_is_none.gltf",
        "scenes[0].extras.sunfleck_env.image: error: this is not an image in a format that is read",
    ),
    ("sky_image_missing.gltf", "nowhere.hdr: error: cannot be read"),
    ("sky_image_on_the_web.gltf", "`https://example.org/sky.hdr` is not a file beside this one"),
    ("sky_rotation_text.gltf", "sunfleck_env"),
    ("ctl_anisotropy_one.gltf", "sunfleck_ctl: error: from 0.0000 s on the value is or comes near 1"),
    ("ctl_channel_unknown.gltf", "sunfleck_ctl.channel: error: `rotation.x` is no channel"),
    ("ctl_density_negative.gltf", "sunfleck_ctl: error: from 0.0000 s on the value is or comes near -0.5"),
    ("ctl_without_target.gltf", "extras.sunfleck_ctl: error: missing field `target`"),
    ("empty.glb", "the file is empty"),
    ("empty.gltf", "the file is empty"),
    ("extension_required_unknown.gltf", "the file requires the extension `ACME_leaves`, which is not read"),
    ("fog_albedo_above_one.gltf", "sunfleck_fog_volume.albedo: error: the albedo is out of range"),
    ("fog_anisotropy_one.gltf", "sunfleck_fog_volume.anisotropy: error: the anisotropy is 1"),
    ("fog_density_negative.gltf", "sunfleck_fog_volume.density: error: the density is negative"),
    ("fog_density_text.gltf", "sunfleck_fog_volume.density: error: neither a number nor three"),
    (
        "fog_height_falloff_negative.gltf",
        "sunfleck_fog.height_falloff: error: the fog grows denser with height",
    ),
    ("fog_height_falloff_text.gltf", "sunfleck_fog.height_falloff: error: "),
    ("fog_layer_even.gltf", "fog without bounds would swallow all sunlight"),
    ("fog_scale_height_zero.gltf", "sunfleck_fog_volume.scale_height: error: the scale height is 0"),
    ("fog_shape_sphere.gltf", "`sphere` is no shape of fog"),
    ("fog_without_bounds.gltf", "fog without bounds would swallow all sunlight"),
    ("frame_rate_zero.gltf", "0 over 1 is no frame rate"),
    ("frames_backwards.gltf", "frame 3 comes before frame 9"),
    ("glb_chunk_too_long.glb", "the GLB container is damaged"),
    ("glb_cut_short.glb", "the file is cut short: it has 200 bytes"),
    ("glb_header_only.glb", "the file is cut short"),
    ("glb_length_zero.glb", "says 0 in its header"),
    ("glb_magic_wrong.glb", "this is no glTF file"),
    ("glb_version_one.glb", "version 1 of the GLB container"),
    ("glb_without_binary.glb", "buffers[0]: error: the buffer has no data"),
    ("index_out_of_range.gltf", "index 2 is 9, and there are 3 vertices"),
    ("json_cut_short.gltf", "the JSON is damaged"),
    ("json_nan.gltf", "the JSON is damaged"),
    ("json_negative_index.gltf", "nodes[1].mesh: error: invalid value: integer `-1`"),
    ("json_type.gltf", "nodes[1].mesh: error: invalid type: string \"leaf\""),
    ("leaf_translucency_above_one.gltf", "sunfleck_leaf.translucency: error: the translucency is 1.2"),
    (
        "leaf_transmit_color_negative.gltf",
        "sunfleck_leaf.transmit_color: error: the colour is [0.5, -0.1, 0.2]",
    ),
    ("leaf_transmit_color_text.gltf", "sunfleck_leaf.transmit_color: error: neither a number nor three"),
    ("leaf_id_negative.gltf", "nodes[1].extras.leaf_id: error: -4 is no leaf id"),
    (
        "light_area_and_spot.gltf",
        "sunfleck_light.type: error: the node is an area light and has another light as well",
    ),
    ("light_area_shape_unknown.gltf", "sunfleck_light.shape: error: `star` is no shape of light"),
    ("light_area_size_text.gltf", "sunfleck_light.size: error: neither a number nor two, width and height"),
    ("light_area_size_zero.gltf", "sunfleck_light.size: error: the size is 0"),
    ("light_area_without_power.gltf", "sunfleck_light: error: the area light has no power"),
    ("light_area_without_size.gltf", "sunfleck_light: error: the area light has no size"),
    ("light_power_negative.gltf", "sunfleck_light.power_w: error: -1 W times [1, 1, 1] is no power"),
    ("light_radius_negative.gltf", "nodes[3].extras.sunfleck_light.radius: error: the radius is -0.1"),
    ("light_sun_angle_pi.gltf", "nodes[3].extras.sunfleck_light.angle: error: the angle is 3.2"),
    ("light_units_unknown.gltf", "`candles` are no light units"),
    (
        "material_sum_above_one.gltf",
        "sunfleck_material: error: base colour, transmission, mirror and filter add up to",
    ),
    ("node_translation_infinite.gltf", "the JSON is damaged: number out of range"),
    ("passes_unknown.gltf", "sunfleck.passes[1]: error: `beauty` is no pass"),
    (
        "shutter_offset_huge.gltf",
        "sunfleck.shutter_offset: error: the shutter opens 1000000 frames after the frame",
    ),
    ("position_nan.gltf", "element 1 of these positions is not finite"),
    ("position_scalar.gltf", "positions cannot be of type `SCALAR`"),
    ("filter_unknown.gltf", "sunfleck.filter: error: `gauss` is no filter"),
    ("resolution_huge.gltf", "resolution[0]: error: 65537 is not usable"),
    ("resolution_zero.gltf", "0 is not usable"),
    ("seed_fraction.gltf", "sunfleck.seed: error: 1.5 is not usable"),
    ("sparse_index_out_of_range.gltf", "element 9 does not exist"),
    ("stride_too_small.gltf", "a byteStride of 4 is less than the element"),
    ("tolerance_above_one.gltf", "sunfleck.tolerance: error: 2 is not usable"),
    ("triangles_not_whole.gltf", "2 vertices of mode 4"),
    ("version_missing.gltf", "asset.version: error"),
    ("version_one.gltf", "asset.version: error: this is glTF version `1.0`"),
    ("version_three.gltf", "asset.version: error: this is glTF version `3.0`"),
    // Written by tests/data/make_invalid_gltf.py.
    ("accessor_count_negative.gltf", "accessors[0].count: error: invalid value: integer `-1`"),
    ("accessor_without_count.gltf", "accessors[0]: error: missing field `count`"),
    ("asset_missing.gltf", "asset.version: error"),
    ("buffer_view_without_length.gltf", "bufferViews[0]: error: missing field `byteLength`"),
    (
        "draco_attribute_without_accessor.gltf",
        "KHR_draco_mesh_compression: error: the primitive has no accessor for the compressed NORMAL",
    ),
    (
        "draco_damaged.gltf",
        "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: error: Draco decode error",
    ),
    ("draco_malformed.gltf", "KHR_draco_mesh_compression: error: the extension is malformed"),
    ("draco_mode_strip.gltf", "KHR_draco_mesh_compression: error: a compressed mesh cannot be of mode 5"),
    ("draco_view_missing.gltf", "KHR_draco_mesh_compression.bufferView: error: buffer view 9 does not exist"),
    ("glb_binary_chunk_first.glb", "the GLB container is damaged: was not expecting BIN"),
    ("glb_json_empty.glb", "the JSON is damaged: EOF while parsing a value"),
    ("glb_without_chunks.glb", "the GLB container is damaged"),
    ("indices_missing.gltf", "meshes[0].primitives[0].indices: error: accessor 9 does not exist"),
    ("indices_of_vectors.gltf", "accessors[1].type: error: indices cannot be of type `VEC3`"),
    ("indices_restart.gltf", "primitives[0].indices: error: index 3 is 65535, and there are 4 vertices"),
    ("json_is_a_list.gltf", "asset.version: error"),
    ("json_is_a_number.gltf", "invalid type: integer `2`"),
    ("json_nested_without_end.gltf", "the JSON is damaged: recursion limit exceeded"),
    ("json_not_utf8.gltf", "30:14: error: the JSON is damaged: invalid unicode code point"),
    ("extension_required_double.gltf", "move the scene near the origin first"),
    ("extension_required_packing.gltf", "plain metallic-roughness"),
    ("extension_required_restart.gltf", "or as plain triangles"),
    ("extension_required_sky.gltf", "the custom property `sunfleck_env`"),
    ("extension_required_splats.gltf", "export triangles"),
    ("extension_required_stream.gltf", "nothing is streamed here"),
    ("extension_required_video.gltf", "a still image in place of the video"),
    (
        "sun_fractal_half_an_iteration.gltf",
        "sunfleck_light.fractal.iterations: error: the number of iterations is 99.5",
    ),
    ("sun_fractal_incomplete.gltf", "sunfleck_light.fractal: error: missing field `imaginary`"),
    ("sun_fractal_of_three.gltf", "sunfleck_light.fractal.imaginary: error: the imaginary is 3"),
    ("sun_fractal_swings_too_far.gltf", "sunfleck_ctl: error: from 0.0000 s on the value is or comes near 3"),
    (
        "sun_image_and_fractal.gltf",
        "nodes[2].extras.sunfleck_light: error: the sun has an image and a fractal",
    ),
    ("sun_image_black.gltf", "sunfleck_light.image: error: the circle in the middle of the image is black"),
    (
        "sun_image_elsewhere.gltf",
        "sunfleck_light.image: error: `https://example.org/sun.png` is not a file beside this one",
    ),
    (
        "sun_image_is_text.gltf",
        "nodes[2].extras.sunfleck_light.image: error: this is not an image in a format that is read",
    ),
    ("sun_limb_above_one.gltf", "sunfleck_light.limb_darkening: error: the limb_darkening is 1.5"),
    ("suns_with_too_many_pictures.gltf", "sunfleck_light: error: too many suns have pictures"),
    ("meshopt_buffer_missing.gltf", "EXT_meshopt_compression.buffer: error: buffer 3 does not exist"),
    (
        "meshopt_count_huge.gltf",
        "EXT_meshopt_compression: error: 1099511627776 elements of 12 bytes are more than 4 compressed bytes hold",
    ),
    (
        "meshopt_damaged.gltf",
        "bufferViews[0].extensions.EXT_meshopt_compression: error: the compressed data are damaged",
    ),
    ("meshopt_filter_unknown.gltf", "EXT_meshopt_compression filter BLUR"),
    ("meshopt_mode_unknown.gltf", "EXT_meshopt_compression mode POINTS"),
    (
        "meshopt_range_beyond_buffer.gltf",
        "EXT_meshopt_compression: error: the view spans 100000 bytes from 60",
    ),
    ("mode_unknown.gltf", "meshes[0].primitives[0].mode: error: 6 vertices of mode 7"),
    ("node_child_negative.gltf", "nodes[0].children[0]: error: invalid value: integer `-1`"),
    ("node_matrix_short.gltf", "nodes[0].matrix: error: invalid length 4"),
    (
        "sparse_count_too_many.gltf",
        "accessors[0].sparse.count: error: more elements are replaced than there are",
    ),
    (
        "sparse_indices_float.gltf",
        "accessors[0].sparse.indices.componentType: error: indices cannot be of this type",
    ),
    ("triangles_none.gltf", "meshes[0].primitives[0].mode: error: 1 vertices of mode 4"),
];

/// File and the kinds of what is lost: it is read without that, or with it put right.
const LENIENT: &[(&str, &[&str])] = &[
    ("albedo_above_one.gltf", &["value-out-of-range"]),
    ("alpha_mode_unknown.gltf", &["value-out-of-range"]),
    ("animation_interpolation_unknown.gltf", &["animation-damaged"]),
    ("animation_key_time_nan.gltf", &["animation-damaged"]),
    ("animation_key_times_decrease.gltf", &["animation-damaged"]),
    ("animation_key_times_of_vectors.gltf", &["animation-damaged"]),
    ("animation_node_missing.gltf", &["animation-damaged"]),
    ("animation_of_matrix_node.gltf", &["animation-damaged"]),
    ("animation_output_count.gltf", &["animation-damaged"]),
    ("animation_output_of_quaternions.gltf", &["animation-damaged"]),
    ("animation_output_short_of_tangents.gltf", &["animation-damaged"]),
    ("animation_path_unknown.gltf", &["animation-damaged"]),
    ("animation_rotation_zero.gltf", &["animation-damaged"]),
    ("animation_sampler_missing.gltf", &["animation-damaged"]),
    ("base_color_negative.gltf", &["value-out-of-range"]),
    ("buffer_cut_short.gltf", &["buffer-unreadable"]),
    ("buffer_view_beyond_buffer.gltf", &["animation-damaged"]),
    ("buffer_view_overflows.gltf", &["animation-damaged"]),
    ("camera_aspect_zero.gltf", &["value-out-of-range"]),
    ("camera_fov_of_half_a_turn.gltf", &["camera-unusable"]),
    ("clearcoat_above_one.gltf", &["value-out-of-range"]),
    ("clearcoat_normal_texture_missing.gltf", &["texture-unreadable"]),
    ("colors_scalar.gltf", &["attribute-damaged"]),
    ("diffuse_transmission_above_one.gltf", &["value-out-of-range"]),
    ("emission_negative.gltf", &["value-out-of-range"]),
    ("extension_required_basisu.gltf", &[]),
    ("extension_required_dds.gltf", &[]),
    ("extension_required_glossiness.gltf", &[]),
    ("image_cut_short.gltf", &["texture-coordinates-missing", "texture-unreadable"]),
    ("image_file_missing.gltf", &["texture-coordinates-missing", "texture-unreadable"]),
    ("image_is_no_image.gltf", &["texture-coordinates-missing", "texture-unreadable"]),
    ("image_missing.gltf", &["texture-coordinates-missing", "texture-unreadable"]),
    ("image_webp_damaged.gltf", &["texture-unreadable"]),
    ("instances_accessor_missing.gltf", &["instances-damaged"]),
    ("instances_of_unequal_number.gltf", &["instances-damaged"]),
    ("instances_rotation_zero.gltf", &["instances-damaged"]),
    ("instances_scale_as_bytes.gltf", &["instances-damaged"]),
    ("ior_negative.gltf", &["value-out-of-range"]),
    ("json_byte_order_mark.gltf", &[]),
    ("light_color_negative.gltf", &["value-out-of-range"]),
    ("light_intensity_negative.gltf", &["value-out-of-range"]),
    ("light_missing.gltf", &["reference-missing"]),
    ("light_spot_angles.gltf", &["light-unusable"]),
    ("light_type_unknown.gltf", &["light-unusable"]),
    ("material_missing.gltf", &["reference-missing"]),
    ("matrix_projective.gltf", &["transform-repaired"]),
    ("mesh_empty.gltf", &["mesh-without-triangles"]),
    ("mesh_missing.gltf", &["reference-missing"]),
    ("mesh_without_positions.gltf", &["mesh-without-triangles", "primitive-without-positions"]),
    ("morph_accessor_missing.gltf", &["morph-targets-damaged"]),
    ("morph_fewer_than_positions.gltf", &["morph-targets-damaged"]),
    ("morph_keys_fewer.gltf", &["animation-damaged"]),
    ("morph_targets_differ.gltf", &["morph-targets-damaged"]),
    ("morph_weights_of_node_huge.gltf", &["morph-targets-damaged"]),
    ("morph_weights_too_many.gltf", &["morph-targets-damaged"]),
    ("node_child_missing.gltf", &["nodes-outside-scene", "reference-missing"]),
    ("node_cycle.gltf", &["hierarchy-repaired", "nodes-outside-scene"]),
    ("node_is_its_own_child.gltf", &["hierarchy-repaired", "nodes-outside-scene"]),
    ("node_matrix_and_parts.gltf", &["transform-repaired"]),
    ("node_rotation_zero.gltf", &["transform-repaired"]),
    ("node_with_two_parents.gltf", &["hierarchy-repaired"]),
    ("normal_texture_missing.gltf", &["texture-coordinates-missing", "texture-unreadable"]),
    ("normals_fewer_than_positions.gltf", &["attribute-damaged"]),
    ("pointer_fov_out_of_range.gltf", &["animation-damaged"]),
    ("pointer_light_missing.gltf", &["animation-damaged"]),
    ("pointer_node_missing.gltf", &["animation-damaged"]),
    ("pointer_roughness_above_one.gltf", &["animation-damaged"]),
    ("pointer_values_of_another_type.gltf", &["animation-damaged"]),
    ("root_is_a_child_too.gltf", &["hierarchy-repaired", "nodes-outside-scene"]),
    ("roughness_above_one.gltf", &["value-out-of-range"]),
    ("scene_missing.gltf", &["reference-missing"]),
    ("scene_node_missing.gltf", &["reference-missing"]),
    ("sheen_color_of_two.gltf", &["value-out-of-range"]),
    ("sheen_roughness_negative.gltf", &["value-out-of-range"]),
    ("skin_joint_beyond_skin.gltf", &["skin-damaged"]),
    ("skin_joint_missing.gltf", &["skin-damaged"]),
    ("skin_joint_outside_scene.gltf", &["nodes-outside-scene", "skin-damaged"]),
    ("skin_joints_as_floats.gltf", &["skin-damaged", "skin-without-joints"]),
    ("skin_joints_without_weights.gltf", &["skin-damaged", "skin-without-joints"]),
    ("skin_matrices_as_vectors.gltf", &["skin-damaged"]),
    ("skin_matrices_fewer.gltf", &["skin-damaged"]),
    ("skin_matrix_projective.gltf", &["skin-damaged"]),
    ("skin_missing.gltf", &["reference-missing"]),
    ("skin_weight_negative.gltf", &["joint-weights"]),
    ("skin_weights_fewer.gltf", &["skin-damaged", "skin-without-joints"]),
    ("skin_without_joints.gltf", &["skin-damaged"]),
    ("specular_color_text.gltf", &["value-out-of-range"]),
    ("tangents_fewer.gltf", &["attribute-damaged"]),
    ("tangents_missing.gltf", &["attribute-damaged"]),
    ("tangents_of_three.gltf", &["attribute-damaged"]),
    ("tangents_u8.gltf", &["attribute-damaged"]),
    ("texture_coordinates_fewer.gltf", &["attribute-damaged"]),
    ("texture_coordinates_of_three.gltf", &["attribute-damaged"]),
    ("texture_coordinates_u32.gltf", &["attribute-damaged"]),
    ("texture_missing.gltf", &["texture-unreadable"]),
    ("texture_sampler_missing.gltf", &["reference-missing"]),
    ("texture_transform_infinite.gltf", &["attribute-damaged"]),
    ("texture_without_image.gltf", &["texture-unreadable"]),
    ("transmission_text.gltf", &["transmission-rough", "value-out-of-range"]),
];

fn data(name: &str) -> PathBuf {
    checkout::file("tests/data").join(name)
}

/// What is said about a file; `None` if it makes a scene.
fn refusal(path: &Path) -> Option<String> {
    match description::load(path) {
        Err(error) => Some(error.diagnostics().to_string()),
        Ok(description) => scene::resolve(description, None).err().map(|diagnostics| diagnostics.to_string()),
    }
}

/// Reads and resolves bytes; the outcome does not matter, that there is one does.
fn survives(bytes: &[u8]) {
    let path = data("blender/changed.glb");
    let mut files = Files::default();
    let Ok(scene) = gltf::parse(bytes, &path, &mut files) else { return };
    let scene = SceneSource::Gltf(scene);
    let description =
        Description { path, scene, sequence: None, content_hash: files.content_hash(), files: Vec::new() };
    let Ok((scene, settings)) = scene::resolve(description, None) else { return };
    let time_s = settings.frame_rate.seconds(*settings.frames.start() as f64);
    assert_eq!(scene.placements(time_s).len(), scene.nodes.len());
}

#[test]
fn every_invalid_file_is_refused_with_its_reason() {
    for (name, reason) in REFUSED.iter().copied() {
        let message =
            refusal(&data("invalid/gltf").join(name)).unwrap_or_else(|| panic!("{name} is not refused"));
        assert!(message.contains(reason), "{name}: {reason} is not in\n{message}");
        assert!(message.contains(name) || message.contains("nowhere."), "{name} is not named in\n{message}");
        for part in ["expected: ", "remedy: "] {
            assert!(message.contains(part), "{name}: no `{part}` in\n{message}");
        }
    }
}

/// Losses that have nothing to do with what is wrong.
const BESIDE: [&str; 2] = ["backface-culling", "no-light"];

#[test]
fn what_can_be_done_without_is_left_out_and_told() {
    for (name, expected) in LENIENT.iter().copied() {
        let description = description::load(&data("lenient/gltf").join(name))
            .unwrap_or_else(|error| panic!("{name} is refused: {error}"));
        let (scene, _) = scene::resolve(description, None)
            .unwrap_or_else(|problems| panic!("{name} is refused: {problems}"));
        let ids: BTreeSet<&str> = scene.remarks.losses().map(|(loss, _)| loss.id()).collect();
        let ids: Vec<&str> = ids.into_iter().filter(|id| !BESIDE.contains(id)).collect();
        assert_eq!(ids, expected, "{name}");
        // What `--strict` refuses.
        assert!(expected.is_empty() || scene.remarks.refusing_losses().is_some(), "{name}");
    }
}

#[test]
fn every_damaged_file_is_in_its_table() {
    let files = |folder: &str| -> BTreeSet<String> {
        let entries = std::fs::read_dir(data(folder)).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    };
    assert_eq!(files("invalid/gltf"), REFUSED.iter().map(|(name, _)| (*name).to_owned()).collect());
    assert_eq!(files("lenient/gltf"), LENIENT.iter().map(|(name, _)| (*name).to_owned()).collect());
}

#[test]
fn the_file_they_were_made_from_is_good() {
    for name in ["leaf.gltf", "leaf.glb"] {
        assert_eq!(refusal(&data("valid/gltf").join(name)), None);
    }
}

/// Good files of every kind, small ones.
fn good_files() -> Vec<Vec<u8>> {
    let names = [
        "valid/gltf/leaf.gltf",
        "valid/gltf/leaf.glb",
        "blender/d_skin.glb",
        "blender/c_morph.glb",
        "blender/g_pbr.glb",
        "blender/h_lights_pointer_scene.glb",
        "blender/i_conventions_nopointer.glb",
        "blender/e_inst_gpu_static.glb",
    ];
    names.iter().map(|name| std::fs::read(data(name)).unwrap()).collect()
}

/// Puts `value` in place of the `nth` value of a JSON tree, counted depth first.
fn replace(tree: &mut Value, nth: &mut usize, value: &Value) {
    if *nth == 0 {
        *tree = value.clone();
    }
    *nth = nth.wrapping_sub(1);
    match tree {
        Value::Array(items) => items.iter_mut().for_each(|item| replace(item, nth, value)),
        Value::Object(fields) => fields.values_mut().for_each(|item| replace(item, nth, value)),
        _ => {}
    }
}

fn count(tree: &Value) -> usize {
    1 + match tree {
        Value::Array(items) => items.iter().map(count).sum(),
        Value::Object(fields) => fields.values().map(count).sum(),
        _ => 0,
    }
}

fn odd_value() -> impl Strategy<Value = Value> {
    let values = [
        "null",
        "true",
        "-1",
        "0",
        "1",
        "2",
        "3",
        "5",
        "4294967295",
        "18446744073709551615",
        "1e300",
        "-1e300",
        "1e-300",
        "0.5",
        "\"\"",
        "\"box\"",
        "\"STEP\"",
        "\"CUBICSPLINE\"",
        "\"MASK\"",
        "\"VEC4\"",
        "5121",
        "5126",
        "[]",
        "{}",
        "[0]",
        "[0,0,0]",
        "[1e300,1e300,1e300]",
        "[0,0,0,0]",
        "[[1]]",
    ];
    prop::sample::select(values.to_vec()).prop_map(|text| serde_json::from_str(text).unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_bytes_never_panic(
        file in 0..8_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        kept in prop::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let mut bytes = good_files().swap_remove(file);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Some(kept) = kept {
            bytes.truncate(kept.index(bytes.len()));
        }
        survives(&bytes);
    }

    #[test]
    fn changed_json_never_panics(
        file in 1..8_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), odd_value()), 1..4),
    ) {
        let bytes = good_files().swap_remove(file);
        let mut glb = ::gltf::Glb::from_slice(&bytes).unwrap();
        let mut json: Value = serde_json::from_slice(&glb.json).unwrap();
        for (at, value) in changes {
            let mut nth = at.index(count(&json));
            replace(&mut json, &mut nth, &value);
        }
        glb.json = serde_json::to_vec(&json).unwrap().into();
        survives(&glb.to_vec().unwrap());
    }
}

/// The place is that of the first byte too many.
#[test]
fn white_space_may_follow_the_json_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("leaf.gltf");
    let leaf = std::fs::read_to_string(data("valid/gltf/leaf.gltf")).unwrap();
    let leaf = leaf.trim_end();
    let line = leaf.lines().count();
    for (rest, place) in
        [("\n \t\r\n", None), ("x", Some([0, 2])), ("\n{}", Some([1, 1])), ("\n\n  \0", Some([2, 3]))]
    {
        std::fs::write(&path, format!("{leaf}{rest}")).unwrap();
        let refused = description::load(&path).err().map(|error| error.diagnostics().to_string());
        let expected = place.map(|[lines, column]| {
            format!("leaf.gltf:{}:{column}: error: the JSON is damaged", line + lines)
        });
        match (refused, expected) {
            (None, None) => {}
            (Some(refused), Some(expected)) => assert!(refused.contains(&expected), "{refused}"),
            (refused, expected) => panic!("{rest:?}: {refused:?}, expected {expected:?}"),
        }
    }
}
