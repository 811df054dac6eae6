//! Rays aimed exactly at edges and vertices of closed meshes: none may pass through.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;
use sunfleck::accel::{InstanceTree, MeshTree, PlacedMesh};
use sunfleck::math::{Ray, Sampler};

/// Rays that share their random numbers' seed.
const BATCH: u64 = 1 << 16;

/// Prints a row for each mesh: triangles, rays, leaks.
pub fn run(rays: u64) {
    let needle = Vec3::new(1.0, 1e-3, 1e-5);
    let meshes = [
        ("octahedron", 0, Vec3::ONE),
        ("sphere", 5, Vec3::ONE),
        ("egg", 3, Vec3::new(0.3, 1.0, 0.05)),
        ("needle", 4, needle),
    ];
    println!("{:<12} {:>9} {:>12} {:>6}", "mesh", "triangles", "rays", "leaks");
    for (name, levels, stretch) in meshes {
        let (positions, triangles) = sphere(levels, stretch);
        let rays = rays.div_ceil(meshes.len() as u64);
        let batches = rays.div_ceil(BATCH);
        let leaks: u64 = (0..batches)
            .into_par_iter()
            .map(|batch| leaks_in_batch(&positions, &triangles, batch as u32))
            .sum();
        println!("{name:<12} {:>9} {:>12} {leaks:>6}", triangles.len(), batches * BATCH);
    }
}

fn leaks_in_batch(positions: &[Vec3], triangles: &[[u32; 3]], batch: u32) -> u64 {
    let mut place = Sampler::new(1, batch, 0, 0);
    let placement = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.5) + vector(&mut place).abs(),
        DQuat::from_scaled_axis(3.0 * vector(&mut place)),
        30.0 * vector(&mut place),
    );
    let mesh = Arc::new(MeshTree::new(positions, triangles));
    let tree = InstanceTree::new(vec![PlacedMesh { mesh, relative_from_mesh: placement }]);
    let inside = placement.translation;
    (0..BATCH as u32)
        .filter(|sample| {
            let mut random = Sampler::new(2, batch, 1, *sample);
            let (which, along) = random.next_2d();
            let (kind, distance) = random.next_2d();
            let triangle = triangles[(which * triangles.len() as f64) as usize];
            let [a, b, c] =
                triangle.map(|vertex| placement.transform_point3(positions[vertex as usize].as_dvec3()));
            let target = if kind < 0.25 { a } else { b + along * (c - b) };
            let beyond = target + (target - inside) * (0.1 + 30.0 * distance);
            let outwards = random.next_1d() < 0.5;
            let (from, to) = if outwards { (inside, beyond) } else { (beyond, inside) };
            let ray = Ray { origin: from, direction: (to - from).normalize() };
            tree.nearest_hit(&ray, (to - from).length(), None).is_none()
        })
        .count() as u64
}

fn vector(random: &mut Sampler) -> DVec3 {
    let ((x, y), z) = (random.next_2d(), random.next_1d());
    2.0 * DVec3::new(x, y, z) - 1.0
}

/// A stretched sphere: an octahedron divided `levels` times.
fn sphere(levels: u32, stretch: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions: Vec<Vec3> = vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for x in [0, 3] {
        for y in [1, 4] {
            triangles.extend([[x, y, 2], [x, y, 5]]);
        }
    }
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |p: u32, q: u32| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    positions.push((positions[p as usize] + positions[q as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (positions.into_iter().map(|position| position * stretch).collect(), triangles)
}
