//! Shiny surfaces, normal maps, vertex colours and textures with coordinates of their own, seen by rays. And
//! what becomes of glTF's material extensions.

use crate::checkout;
use crate::common::{EXACT, INSTANT, add_light, camera_at, place};
use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_PI, PI};
use sunfleck::color::Rgb;
use sunfleck::description;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scattering::Gloss;
use sunfleck::scene::{
    self, AlphaMode, Clearcoat, Coat, Instance, LightKind, Material, Mesh, Scene, Sheen, Texture, TextureMap,
    Triangle, Wrap,
};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};

const METAL: Coat =
    Coat { metallic: 1.0, roughness: 0.5, texture: None, f0: Rgb::splat(0.04), f0_texture: None, f90: 1.0 };

/// A large square 3 m before the camera; `u` goes to the right and `v` down.
fn square(material: Material) -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    let node = place(&mut scene, DAffine3::from_translation(3.0 * DVec3::NEG_Z));
    scene.materials.push(material);
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| Vec2::new(u, v));
    scene.meshes.push(Mesh {
        positions: corners.map(|uv| Vec3::new(uv.x - 0.5, 0.5 - uv.y, 0.0) * 8.0).to_vec(),
        uvs: corners.to_vec(),
        tangents: vec![Vec4::X + Vec4::W; 4],
        triangles: [[0, 3, 2], [0, 2, 1]].map(|vertices| Triangle { vertices, material: 0 }).to_vec(),
        ..Mesh::default()
    });
    scene.instances.push(Instance { node, mesh: 0, material: None, leaf_id: 1, deformation: None });
    scene
}

fn add_texture(scene: &mut Scene, texel: [f32; 3]) -> TextureMap {
    let [r, g, b] = texel;
    let wrap = [Wrap::Repeat; 2];
    let texture =
        Texture { name: String::new(), width: 1, height: 1, texels: vec![[r, g, b, 1.0]].into(), wrap };
    scene.textures.push(texture);
    TextureMap { texture: scene.textures.len() - 1, layer: 0 }
}

fn lit(mut scene: Scene, to_sun: DVec3) -> Scene {
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, -to_sun, Rgb::splat(7.0));
    scene
}

fn seen(scene: &Scene, direction: DVec3) -> Rgb {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let ray = Ray { origin: DVec3::ZERO, direction: direction.normalize() };
    radiance(&snapshot, &EXACT, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default()).radiance
}

fn assert_close(found: Rgb, expected: Rgb) {
    let error = (found - expected).abs().max_element() / expected.max_element();
    assert!(error <= 1e-9, "{found} {expected}: {error:.1e}");
}

/// The specification's formulas, written as they stand there (glTF 2.0, B.3.2), and what metal reflects
/// again: the series of all further reflections, each of the share of light that meets another microfacet.
#[test]
fn a_metal_is_that_of_the_specification() {
    let base = Rgb::new(0.9, 0.6, 0.2);
    for (roughness, to_sun, toward) in [
        (0.5, DVec3::new(0.3, 0.2, 1.0), DVec3::new(0.2, -0.1, -1.0)),
        (0.15, DVec3::new(-0.2, 0.1, 0.9), DVec3::new(-0.2, 0.1, -1.0)),
        (1.0, DVec3::new(1.0, 1.0, 0.4), DVec3::new(0.5, 0.4, -1.0)),
    ] {
        let coat = Some(Coat { roughness, ..METAL });
        let scene = lit(square(Material { base_color: base, coat, ..Material::default() }), to_sun);
        let (v, l, n) = (-toward.normalize(), to_sun.normalize(), DVec3::Z);
        let h = (v + l).normalize();
        let a2 = f64::powi(roughness, 4);
        let d = a2 / (PI * (n.dot(h).powi(2) * (a2 - 1.0) + 1.0).powi(2));
        let g1 = |cos: f64| 2.0 * cos / (cos + (a2 + (1.0 - a2) * cos * cos).sqrt());
        let g = g1(n.dot(l)) * g1(n.dot(v));
        let f = base + (Rgb::ONE - base) * (1.0 - v.dot(h)).powi(5);
        let once = f * d * g / (4.0 * n.dot(l) * n.dot(v));
        assert_close(Gloss::new(base, Rgb::ONE, roughness).brdf(n, v, l), once);
        let gloss = Gloss::new(METAL.f0, Rgb::ONE, roughness).with_metal(1.0, base, Rgb::ONE);
        let metal = gloss.brdf(n, v, l);
        assert_close(seen(&scene, toward), metal * n.dot(l) * 7.0);

        let white = |cos: f64| Gloss::new(Rgb::ONE, Rgb::ONE, roughness).albedo(cos).x;
        let cosines = (0..4000).map(|index| (f64::from(index) + 0.5) / 4000.0);
        let mean = cosines.map(|cos| 2.0 * cos * white(cos) / 4000.0).sum::<f64>();
        let bounce = base + (Rgb::ONE - base) / 21.0;
        let further =
            (0..100).map(|n| bounce * mean * (bounce * (1.0 - mean)).powf(f64::from(n))).sum::<Rgb>();
        let expected = Rgb::ONE + further * (1.0 - white(n.dot(v))) / white(n.dot(v));
        let off = (metal / once / expected - 1.0).abs().max_element();
        assert!(off < 1e-4, "{roughness}: {off:.1e}");
    }
}

#[test]
fn textures_multiply_metallic_and_roughness() {
    let (to_sun, toward) = (DVec3::new(0.3, 0.2, 1.0), DVec3::new(0.2, -0.1, -1.0));
    let mut mapped = square(Material::default());
    let texture = Some(add_texture(&mut mapped, [0.9, 0.5, 0.25]));
    mapped.materials[0].coat = Some(Coat { metallic: 0.8, roughness: 0.6, texture, ..METAL });
    let mut plain = square(Material::default());
    plain.materials[0].coat = Some(Coat { metallic: 0.2, roughness: 0.3, ..METAL });
    assert_close(seen(&lit(mapped, to_sun), toward), seen(&lit(plain, to_sun), toward));
}

/// A coat that reflects nothing is none; one over a dark surface is all there is; one over a
/// leaf lets light through.
#[test]
fn what_lies_beneath_the_coat() {
    let (to_sun, toward) = (DVec3::new(0.3, 0.2, 1.0), DVec3::new(0.2, -0.1, -1.0));
    let look = |coat: Option<Coat>, to_sun: DVec3| {
        let transmission = Rgb::new(0.1, 0.2, 0.1);
        seen(&lit(square(Material { coat, transmission, ..Material::default() }), to_sun), toward)
    };
    let nothing = Coat { metallic: 0.0, f0: Rgb::ZERO, f90: 0.0, ..METAL };
    assert_close(look(Some(nothing), to_sun), look(None, to_sun));
    assert_close(look(Some(nothing), -to_sun), look(None, -to_sun));
    let dielectric = Coat { metallic: 0.0, ..METAL };
    let (bare, coated) = (look(None, -to_sun), look(Some(dielectric), -to_sun));
    assert!(coated.cmplt(bare).all() && coated.cmpgt(0.85 * bare).all(), "{coated} {bare}");
    assert_eq!(look(Some(METAL), -to_sun), Rgb::ZERO);
}

/// A tilted normal: to the right in the texture and up in it, and the same seen from behind.
#[test]
fn normal_maps_tilt_the_normal() {
    let (sin, cos) = 0.3_f64.sin_cos();
    for (texel, tilted) in [
        (DVec3::new(sin, 0.0, cos), DVec3::new(sin, 0.0, cos)),
        (DVec3::new(0.0, sin, cos), DVec3::new(0.0, sin, cos)),
        (DVec3::new(0.0, 0.0, 1.0), DVec3::Z),
    ] {
        for is_behind in [false, true] {
            let mut scene = square(Material { base_color: Rgb::ONE, ..Material::default() });
            let code = 0.5 * texel + 0.5;
            let map = add_texture(&mut scene, code.as_vec3().to_array());
            scene.materials[0].normal_map = Some((map, 1.0));
            let mut normal = tilted;
            if is_behind {
                // Turned about the vertical: right is left, and the normal is that of the other side.
                let turned = DAffine3::from_translation(3.0 * DVec3::NEG_Z) * DAffine3::from_rotation_y(PI);
                scene.instances[0].node = place(&mut scene, turned);
                normal = -DVec3::new(-tilted.x, tilted.y, -tilted.z);
            }
            let to_sun = DVec3::new(0.2, 0.4, 1.0).normalize();
            let found = seen(&lit(scene, to_sun), DVec3::NEG_Z).x;
            let expected = FRAC_1_PI * normal.dot(to_sun) * 7.0;
            assert!((found / expected - 1.0).abs() < 1e-6, "{texel} {is_behind}: {found} {expected}");
        }
    }
}

#[test]
fn a_normal_map_of_scale_zero_does_nothing() {
    let to_sun = DVec3::new(0.2, 0.4, 1.0);
    let mut scene = square(Material::default());
    let map = add_texture(&mut scene, [0.9, 0.2, 0.7]);
    scene.materials[0].normal_map = Some((map, 0.0));
    let toward = DVec3::new(0.3, 0.2, -1.0);
    assert_close(seen(&lit(scene, to_sun), toward), seen(&lit(square(Material::default()), to_sun), toward));
}

#[test]
fn vertex_colours_multiply_and_other_layers_have_their_own_coordinates() {
    let mut scene = square(Material { base_color: Rgb::splat(0.5), ..Material::default() });
    // From left to right red turns into green.
    scene.meshes[0].colors = vec![Vec3::X, Vec3::Y, Vec3::Y, Vec3::X];
    let texels = vec![[1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]].into();
    let wrap = [Wrap::Clamp; 2];
    scene.textures.push(Texture { name: String::new(), width: 2, height: 1, texels, wrap });
    scene.materials[0].emission = Rgb::splat(4.0);
    scene.materials[0].emission_texture = Some(TextureMap { texture: 0, layer: 1 });
    // Turned by a right angle: the dark half is below.
    let turned: Vec<Vec2> = scene.meshes[0].uvs.iter().map(|uv| Vec2::new(uv.y, uv.x)).collect();
    scene.meshes[0].more_uvs.push(turned);
    let scene = lit(scene, DVec3::Z);
    for (at, shine) in [(DVec2::new(-1.0, 3.0), 4.0), (DVec2::new(2.0, -3.0), 0.0)] {
        let u = at.x / 8.0 + 0.5;
        let expected = FRAC_1_PI * 0.5 * 7.0 * Rgb::new(1.0 - u, u, 0.0) + Rgb::splat(shine);
        let found = seen(&scene, at.extend(-3.0));
        assert!((found - expected).abs().max_element() < 1e-6, "{found} {expected}");
    }
}

/// A coat reflects by its own normal, and takes what it reflects from what the surface gives.
#[test]
fn a_clear_coat_lies_over_all() {
    let (to_sun, toward) = (DVec3::new(0.3, 0.2, 1.0), DVec3::new(0.2, -0.1, -1.0));
    let coat =
        Clearcoat { share: 0.8, texture: None, roughness: 0.4, roughness_texture: None, normal_map: None };
    let look = |material: Material, with: &dyn Fn(&mut Scene)| {
        let mut scene = square(material);
        with(&mut scene);
        seen(&lit(scene, to_sun), toward)
    };
    let black = Material { base_color: Rgb::ZERO, clearcoat: Some(coat), ..Material::default() };
    let alone = look(black.clone(), &|_| {});
    let gloss = Gloss::new(Rgb::splat(0.04 * 0.8), Rgb::splat(0.8), 0.4);
    let (v, l) = (-toward.normalize(), to_sun.normalize());
    assert_close(alone, 7.0 * l.z * gloss.brdf(DVec3::Z, v, l));
    // A map of the surface does not bend the coat, one of its own does.
    let bump = [0.7, 0.3, 0.9];
    let below = look(black.clone(), &|scene| {
        let map = add_texture(scene, bump);
        scene.materials[0].normal_map = Some((map, 1.0));
    });
    assert_close(below, alone);
    let bent = look(black.clone(), &|scene| {
        let map = add_texture(scene, bump);
        scene.materials[0].clearcoat.as_mut().unwrap().normal_map = Some((map, 1.0));
    });
    assert!((bent / alone - 1.0).abs().max_element() > 0.05, "{bent} {alone}");
    // Textures multiply: red the share, green the roughness.
    let mapped = look(black, &|scene| {
        let (share, roughness) = (add_texture(scene, [0.5, 0.1, 0.1]), add_texture(scene, [0.1, 0.5, 0.1]));
        let (texture, roughness_texture) = (Some(share), Some(roughness));
        let coat = Clearcoat { share: 1.6, roughness: 0.8, texture, roughness_texture, ..coat };
        scene.materials[0].clearcoat = Some(coat);
    });
    assert_close(mapped, alone);
    // Lambert and emission beneath: E is that of the larger of both angles, or of the eye's.
    let taken = [v, l].map(|direction| gloss.albedo(direction.z).x);
    let matte = look(Material { clearcoat: Some(coat), ..Material::default() }, &|_| {});
    let expected = 7.0 * l.z * FRAC_1_PI * 0.8 * (1.0 - taken[0].max(taken[1]));
    assert_close(matte - alone, Rgb::splat(expected));
    let dark = Material { base_color: Rgb::ZERO, clearcoat: Some(coat), ..Material::default() };
    let shining = look(Material { emission: Rgb::splat(3.0), ..dark }, &|_| {});
    assert_close(shining - alone, Rgb::splat(3.0 * (1.0 - taken[0])));
}

#[test]
fn sheen_shines_in_its_colour_and_takes_what_it_gives() {
    let (to_sun, toward) = (DVec3::new(1.0, 0.2, 0.5), DVec3::new(0.9, -0.1, -1.0));
    let sheen = Sheen {
        color: Rgb::new(0.8, 0.4, 0.0),
        color_texture: None,
        roughness: 0.6,
        roughness_texture: None,
    };
    let mut scene = square(Material { base_color: Rgb::ZERO, sheen: Some(sheen), ..Material::default() });
    let alone = seen(&lit(scene.clone(), to_sun), toward);
    assert!((alone.x / alone.y - 2.0).abs() < 1e-9 && alone.z == 0.0 && alone.x > 0.0, "{alone}");
    // Colour by colour, roughness by alpha.
    let color_texture = Some(add_texture(&mut scene, [1.0, 0.5, 1.0]));
    let rough = add_texture(&mut scene, [0.2; 3]);
    scene.textures[rough.texture].texels = vec![[0.2, 0.2, 0.2, 0.75]].into();
    let color = Rgb::new(0.8, 0.8, 0.0);
    scene.materials[0].sheen =
        Some(Sheen { color, color_texture, roughness: 0.8, roughness_texture: Some(rough) });
    assert_close(seen(&lit(scene, to_sun), toward), alone);
    let white = seen(&lit(square(Material { base_color: Rgb::ONE, ..Material::default() }), to_sun), toward);
    let over = Material { base_color: Rgb::ONE, sheen: Some(sheen), ..Material::default() };
    let over = seen(&lit(square(over), to_sun), toward);
    // What it takes is the same in all channels.
    let beneath = over - alone;
    assert!(beneath.cmplt(white).all() && beneath.cmpgt(0.4 * white).all(), "{beneath} {white}");
    assert_close(beneath, Rgb::splat(beneath.z));
}

/// The scene of a small glTF file with another material.
fn with_material(material: Value) -> Scene {
    let path = checkout::file("tests/data/valid/gltf/leaf.gltf");
    let mut file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    file["materials"][0] = material;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("leaf.gltf");
    std::fs::write(&path, serde_json::to_vec(&file).unwrap()).unwrap();
    let description = description::load(&path).map_err(|error| error.diagnostics().to_string()).unwrap();
    scene::resolve(description, None).map_err(|error| error.to_string()).unwrap().0
}

#[test]
fn extensions_of_gltf_materials() {
    let of = |extension: &str, values: Value| {
        let pbr =
            json!({ "baseColorFactor": [0.6, 0.4, 0.2, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.4 });
        let material = json!({ "pbrMetallicRoughness": pbr, "extensions": { extension: values } });
        with_material(material).materials[0].clone()
    };
    let base = Rgb::new(0.6, 0.4, 0.2);
    let near = |a: Rgb, b: Rgb| (a - b).abs().max_element() < 1e-12;

    let plain = of("KHR_materials_ior", json!({}));
    let coat = plain.coat.unwrap();
    assert!(near(coat.f0, Rgb::splat(0.04)) && (coat.f90, coat.roughness, coat.metallic) == (1.0, 0.4, 0.0));
    let water = of("KHR_materials_ior", json!({ "ior": 1.33 }));
    assert!(near(water.coat.unwrap().f0, Rgb::splat((0.33_f64 / 2.33).powi(2))));
    let tinted =
        of("KHR_materials_specular", json!({ "specularFactor": 0.5, "specularColorFactor": [1, 2, 100] }));
    assert!(near(tinted.coat.unwrap().f0, 0.5 * Rgb::new(0.04, 0.08, 1.0)));
    assert_eq!(tinted.coat.unwrap().f90, 0.5);
    assert_eq!(of("KHR_materials_specular", json!({ "specularFactor": 0 })).coat, None);

    let leaf = of(
        "KHR_materials_diffuse_transmission",
        json!({ "diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [0.8, 0.9, 0.1] }),
    );
    assert!(near(leaf.base_color, 0.75 * base) && near(leaf.transmission, 0.25 * Rgb::new(0.8, 0.9, 0.1)));

    let glass = of("KHR_materials_transmission", json!({ "transmissionFactor": 0.75 }));
    assert!(near(glass.base_color, 0.25 * base) && near(glass.filter_color, 0.75 * base));
    assert_eq!((glass.alpha_mode, glass.opacity), (AlphaMode::Blend, 1.0));

    let coated =
        of("KHR_materials_clearcoat", json!({ "clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25 }));
    let coat = coated.clearcoat.unwrap();
    assert_eq!((coat.share, coat.roughness, coat.texture, coated.sheen), (0.5, 0.25, None, None));
    assert_eq!(of("KHR_materials_clearcoat", json!({ "clearcoatRoughnessFactor": 0.25 })).clearcoat, None);
    let cloth =
        of("KHR_materials_sheen", json!({ "sheenColorFactor": [0.5, 0, 1], "sheenRoughnessFactor": 0.5 }));
    let sheen = cloth.sheen.unwrap();
    assert_eq!((sheen.color, sheen.roughness, cloth.clearcoat), (Rgb::new(0.5, 0.0, 1.0), 0.5, None));

    let unlit = of("KHR_materials_unlit", json!({}));
    assert!(near(unlit.emission, base) && unlit.base_color == Rgb::ZERO && unlit.coat.is_none());
}

#[test]
fn blenders_material_with_all_its_maps() {
    let path = checkout::file("tests/data/blender/g_pbr.glb");
    let description = description::load(&path).unwrap();
    let scene = scene::resolve(description, None).unwrap().0;
    let material = scene.materials.iter().find(|material| material.name == "pbr_full").unwrap();
    let coat = material.coat.unwrap();
    let (normal, scale) = material.normal_map.unwrap();
    // The base colour has a transform, metallic and roughness the second set, the others the first.
    let layers = [coat.texture.unwrap().layer, normal.layer, material.emission_texture.unwrap().layer];
    assert_eq!(layers, [2, 1, 1]);
    assert!((scale - 0.7).abs() < 1e-6 && (coat.metallic, coat.roughness) == (1.0, 1.0));
    let mesh = scene.meshes.iter().find(|mesh| mesh.more_uvs.len() == 2).unwrap();
    assert!(mesh.more_uvs.iter().all(|uvs| uvs.len() == mesh.positions.len()));
    assert!(scene.meshes.iter().any(|mesh| mesh.name == "vcol" && mesh.colors.len() == mesh.positions.len()));
}

/// What Blender writes where no material uses the vertex colours: white first, and what was painted after it.
#[test]
fn a_white_filler_is_no_colour() {
    let path = checkout::file("tests/data/blender/f_plain.glb");
    let description = description::load(&path).unwrap();
    let scene = scene::resolve(description, None).unwrap().0;
    assert!(scene.meshes.iter().all(|mesh| mesh.colors.is_empty()));
    assert!(scene.remarks.to_string().contains("vertex colours after the first are not honoured"));
}

/// Half of 255 is half a roughness, and far less than half the light.
#[test]
fn roughness_is_no_colour() {
    use base64::prelude::{BASE64_STANDARD, Engine};
    let mut png = std::io::Cursor::new(Vec::new());
    let grey = image::RgbImage::from_pixel(1, 1, image::Rgb([128; 3]));
    grey.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let uri = format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png.into_inner()));
    let path = checkout::file("tests/data/valid/gltf/leaf.gltf");
    let mut file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    file["images"] = json!([{ "uri": uri }]);
    file["textures"] = json!([{ "source": 0 }]);
    let texture = json!({ "index": 0 });
    file["materials"][0] = json!({ "normalTexture": texture, "emissiveTexture": texture, "emissiveFactor": [1, 1, 1],
        "pbrMetallicRoughness": { "metallicRoughnessTexture": texture } });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("leaf.gltf");
    std::fs::write(&path, serde_json::to_vec(&file).unwrap()).unwrap();
    let scene = scene::resolve(description::load(&path).unwrap(), None).unwrap().0;
    let material = &scene.materials[0];
    let texel = |map: TextureMap| scene.textures[map.texture].texels.get(0)[1];
    let half = 128.0 / 255.0;
    assert!((texel(material.coat.unwrap().texture.unwrap()) - half).abs() < 1e-6);
    assert!((texel(material.normal_map.unwrap().0) - half).abs() < 1e-6);
    assert!((texel(material.emission_texture.unwrap()) - 0.2158605).abs() < 1e-6);
    assert_eq!(scene.textures.len(), 2, "each encoding once");
}
