//! Masked cards as they are rendered: rays against the texture's own alpha.
#![allow(clippy::unwrap_used)]

mod common;

use common::{EXACT, INSTANT};
use glam::{DVec2, DVec3, Vec2};
use std::path::Path;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{OUTLINE_TOLERANCE_TEXELS, Scene};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};
use sunfleck::{description, scene};

const SIZE: u32 = 96;

/// A heart with soft edges and a hole.
fn alpha(p: DVec2) -> f64 {
    let q = (p / f64::from(SIZE) - DVec2::new(0.5, 0.55)) * DVec2::new(2.6, -2.6);
    let heart = (q.length_squared() - 1.0).powi(3) - q.x * q.x * q.y.powi(3);
    let hole = (p - DVec2::new(40.0, 52.0)).length() - 9.0;
    (0.5 - 6.0 * heart).min(0.5 + 0.5 * hole).clamp(0.0, 1.0)
}

/// The scene of a card from -2 to 2 on the ground, seen from 5 m above it.
fn card(folder: &Path, material: &str) -> Scene {
    let image = image::RgbaImage::from_fn(SIZE, SIZE, |x, y| {
        let texel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        image::Rgba([200, 120, 40, (255.0 * alpha(texel)).round() as u8])
    });
    image.save(folder.join("heart.png")).unwrap();
    let text = format!(
        "Scene(version: 1, meshes: {{ \"card\": Quad(size_m: 4.0) }}, materials: {{ \"heart\": (texture: \"heart.png\", {material}) }},
        objects: {{ \"card\": (mesh: \"card\", material: \"heart\"), \"again\": (mesh: \"card\", material: \"heart\", translation_m: (9.0, 0.0, 0.0)) }},
        lights: {{ \"sun\": Sun(to_sun: (0.0, 1.0, 0.0), irradiance_w_per_m2: 1.0) }},
        cameras: {{ \"main\": (position_m: (0.0, 5.0, 0.0), rotation_deg: (-90.0, 0.0, 0.0)) }})"
    );
    let path = folder.join("scene.ron");
    std::fs::write(&path, text).unwrap();
    let description = description::load(&path).map_err(|error| error.to_string()).unwrap();
    scene::resolve(description, None).map_err(|error| error.to_string()).unwrap().0
}

#[test]
fn rays_meet_what_the_texture_shows() {
    let folder = tempfile::tempdir().unwrap();
    for (material, cutoff) in [("alpha_cutoff: 0.5", 0.5), ("alpha_cutoff: 0.3, opacity: 0.5", 0.6)] {
        let scene = card(folder.path(), material);
        assert_eq!(scene.instances[0].mesh, scene.instances[1].mesh, "cut once");
        assert!(scene.remarks.to_string().contains("`card` from 2 triangles to "), "{}", scene.remarks);
        let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
        assert!(!snapshot.has_blended());
        let (mut scratch, mut sampler) = (Scratch::default(), Sampler::new(3, 0, 0, 0));
        let (mut shown, mut near) = (0, 0);
        let count = 20_000;
        for _ in 0..count {
            let (u, v) = sampler.next_2d();
            let place = DVec3::new(4.0 * u - 2.0, -5.0, 4.0 * v - 2.0);
            let ray = Ray { origin: DVec3::ZERO, direction: place.normalize() };
            let found = radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut scratch).surface.is_some();
            let texel = DVec2::new(u, v) * f64::from(SIZE);
            let value = |texel: DVec2| {
                let uv: Vec2 = (texel / f64::from(SIZE)).as_vec2();
                scene.textures[0].alpha(uv)
            };
            let expected = value(texel) >= cutoff;
            let around = (0..12).map(|step| DVec2::from_angle(f64::from(step) * std::f64::consts::PI / 6.0));
            if around
                .into_iter()
                .any(|to| (value(texel + 1.2 * OUTLINE_TOLERANCE_TEXELS * to) >= cutoff) != expected)
            {
                near += 1;
                continue;
            }
            assert_eq!(found, expected, "at texel {texel}");
            shown += usize::from(found);
        }
        assert!(shown > count / 5 && near < count / 20, "{shown} shown, {near} near the edge");
    }
}

#[test]
fn masks_that_show_all_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let all = card(folder.path(), "alpha_cutoff: 0.0");
    assert_eq!(all.meshes[all.instances[0].mesh].triangles.len(), 2);
    assert!(!all.remarks.to_string().contains("masked meshes"));
    let nothing = card(folder.path(), "alpha_cutoff: 0.5, opacity: 0.2");
    assert!(nothing.instances.is_empty());
    assert!(nothing.remarks.to_string().contains("`card` from 2 triangles to 0"), "{}", nothing.remarks);
}
