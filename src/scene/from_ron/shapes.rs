//! Built-in shapes. In go sizes, out come meshes. Invariant: closed shapes share their vertices, so they have
//! no cracks; triangles are counter-clockwise seen from outside or above.

use crate::description::ron;
use crate::scene::{Mesh, Triangle};
use glam::{Vec2, Vec3};
use std::f64::consts::{PI, TAU};

/// Mesh of a built-in shape; `None` for one in a file.
pub(super) fn built_in(name: &str, shape: &ron::Shape) -> Option<Mesh> {
    let mesh = match shape {
        ron::Shape::Obj(_) | ron::Shape::ObjWith { .. } => return None,
        ron::Shape::Quad { size_m } => card(size_m.si() as f32, size_m.si() as f32),
        ron::Shape::Card { length_m, width_m } => card(width_m.si() as f32, length_m.si() as f32),
        ron::Shape::Cube { size_m } => cube(size_m.si() as f32),
        ron::Shape::Sphere { radius_m } => sphere(radius_m.si()),
        ron::Shape::Leaf { length_m, width_m, curl_deg, fold_deg } => {
            leaf(length_m.si(), width_m.si(), curl_deg.si(), fold_deg.si())
        }
    };
    Some(Mesh { name: name.to_owned(), ..mesh })
}

/// Triangle with the default material.
fn triangle(a: usize, b: usize, c: usize) -> Triangle {
    Triangle { vertices: [a as u32, b as u32, c as u32], material: 0 }
}

fn card(width: f32, length: f32) -> Mesh {
    let corners = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)];
    Mesh {
        positions: corners.map(|(u, v)| Vec3::new((u - 0.5) * width, 0.0, (v - 0.5) * length)).to_vec(),
        uvs: corners.map(|(u, v)| Vec2::new(u, v)).to_vec(),
        triangles: vec![triangle(0, 1, 2), triangle(0, 2, 3)],
        ..Mesh::default()
    }
}

fn cube(size: f32) -> Mesh {
    // Index of a corner: bit 0 is x, bit 1 is y, bit 2 is z.
    let corner = |number: usize| {
        let side = |bit: usize| ((number >> bit) & 1) as f32 - 0.5;
        Vec3::new(side(0), side(1), side(2)) * size
    };
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: faces.iter().flat_map(|&[a, b, c, d]| [triangle(a, b, c), triangle(a, c, d)]).collect(),
        ..Mesh::default()
    }
}

/// Segments of a sphere from pole to pole; it has twice as many around.
const SPHERE_RINGS: usize = 32;

fn sphere(radius: f64) -> Mesh {
    let around = 2 * SPHERE_RINGS;
    let mut normals = vec![Vec3::Y];
    for ring in 1..SPHERE_RINGS {
        let (ring_radius, y) = (PI * ring as f64 / SPHERE_RINGS as f64).sin_cos();
        normals.extend((0..around).map(|step| {
            let (sin, cos) = (TAU * step as f64 / around as f64).sin_cos();
            Vec3::new((ring_radius * sin) as f32, y as f32, (ring_radius * cos) as f32)
        }));
    }
    normals.push(Vec3::NEG_Y);
    let south = normals.len() - 1;
    let vertex = |ring: usize, step: usize| match ring {
        0 => 0,
        SPHERE_RINGS => south,
        _ => 1 + (ring - 1) * around + step % around,
    };
    let mut triangles = Vec::new();
    for ring in 0..SPHERE_RINGS {
        for step in 0..around {
            let (above, above_next) = (vertex(ring, step), vertex(ring, step + 1));
            let (below, below_next) = (vertex(ring + 1, step), vertex(ring + 1, step + 1));
            // At the poles one of the two triangles is degenerate.
            if ring > 0 {
                triangles.push(triangle(above, below, above_next));
            }
            if ring + 1 < SPHERE_RINGS {
                triangles.push(triangle(above_next, below, below_next));
            }
        }
    }
    Mesh {
        positions: normals.iter().map(|normal| *normal * radius as f32).collect(),
        normals,
        triangles,
        ..Mesh::default()
    }
}

/// Segments of a leaf from stalk to tip.
const LEAF_STRETCHES: usize = 8;

fn leaf(length: f64, width: f64, curl: f64, fold: f64) -> Mesh {
    let mut mesh = Mesh::default();
    // Vertices: the stalk, then left edge, vein and right edge at every station, then the tip.
    for station in 0..=LEAF_STRETCHES {
        let along = station as f64 / LEAF_STRETCHES as f64;
        let half_width = 0.5 * width * outline(along);
        let ends = station == 0 || station == LEAF_STRETCHES;
        for side in if ends { &[0.0][..] } else { &[-1.0, 0.0, 1.0] } {
            let across = side * half_width;
            let lift = half_width * f64::abs(*side) * fold.sin();
            let (bent_along, bent_down, (sin, cos)) = bend(length * (along - 0.5), length, curl);
            let position = [across * fold.cos(), lift * cos - bent_down, -(bent_along + lift * sin)];
            mesh.positions.push(Vec3::from_array(position.map(|coordinate| coordinate as f32)));
            let u = if width > 0.0 { 0.5 + across / width } else { 0.5 };
            mesh.uvs.push(Vec2::new(u as f32, (1.0 - along) as f32));
        }
    }
    let tip = mesh.positions.len() - 1;
    let row = |station: usize| match station {
        0 => [0; 3],
        LEAF_STRETCHES => [tip; 3],
        _ => [3 * station - 2, 3 * station - 1, 3 * station],
    };
    for station in 0..LEAF_STRETCHES {
        let (near, far) = (row(station), row(station + 1));
        for half in 0..2 {
            let candidates = [
                triangle(near[half], near[half + 1], far[half + 1]),
                triangle(near[half], far[half + 1], far[half]),
            ];
            // At the stalk and the tip one of the two triangles is degenerate.
            mesh.triangles.extend(
                candidates
                    .into_iter()
                    .filter(|Triangle { vertices: [a, b, c], .. }| a != b && b != c && c != a),
            );
        }
    }
    mesh
}

/// Half width of the outline, 0 at stalk and tip, 1 at the widest place, which is nearer to the stalk.
fn outline(along: f64) -> f64 {
    (PI * along.powf(0.75)).sin().max(0.0)
}

/// Bends the vein into an arc of angle `curl`: coordinates along and down, and the local slope.
fn bend(along: f64, length: f64, curl: f64) -> (f64, f64, (f64, f64)) {
    let angle = curl * along / length;
    // sin(x)/x and (1 - cos x)/x, which tend to 1 and 0 for a flat leaf.
    let sine_ratio = if angle.abs() < 1e-6 { 1.0 } else { angle.sin() / angle };
    let versine_ratio = if angle.abs() < 1e-6 { 0.5 * angle } else { (1.0 - angle.cos()) / angle };
    (along * sine_ratio, along * versine_ratio, angle.sin_cos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    fn volume(mesh: &Mesh) -> f32 {
        let corner = |index: u32| mesh.positions[index as usize];
        mesh.triangles
            .iter()
            .map(|t| corner(t.vertices[0]).dot(corner(t.vertices[1]).cross(corner(t.vertices[2]))) / 6.0)
            .sum()
    }

    fn area_and_mean_normal(mesh: &Mesh) -> (f32, Vec3) {
        let corner = |index: u32| mesh.positions[index as usize];
        mesh.triangles.iter().fold((0.0, Vec3::ZERO), |(area, normal), t| {
            let [a, b, c] = t.vertices.map(corner);
            let twice = (b - a).cross(c - a);
            (area + 0.5 * twice.length(), normal + twice)
        })
    }

    fn assert_closed(mesh: &Mesh) {
        let mut edges = HashMap::new();
        for [a, b, c] in mesh.triangles.iter().map(|t| t.vertices) {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        for (&(a, b), &count) in &edges {
            assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
        }
    }

    #[test]
    fn cube_and_sphere_are_closed_and_turned_outwards() {
        assert_closed(&cube(2.0));
        assert!((volume(&cube(2.0)) - 8.0).abs() < 1e-5);
        assert_closed(&sphere(1.0));
        let ratio = volume(&sphere(1.0)) / (4.0 / 3.0 * PI as f32);
        assert!(0.99 < ratio && ratio < 1.0, "{ratio}");
    }

    #[test]
    fn quad_faces_up_with_its_texture_upright_from_above() {
        let quad = card(3.0, 3.0);
        let (area, normal) = area_and_mean_normal(&quad);
        assert!((area - 9.0).abs() < 1e-5);
        assert!(normal.normalize().abs_diff_eq(Vec3::Y, 1e-6));
        let top = card(0.3, 0.5).positions[3];
        assert!(top.abs_diff_eq(Vec3::new(-0.15, 0.0, -0.25), 1e-6), "its picture's upper left is {top}");
    }

    #[test]
    fn flat_leaf_has_its_size_and_faces_up() {
        let leaf = leaf(0.1, 0.05, 0.0, 0.0);
        let (area, normal) = area_and_mean_normal(&leaf);
        assert!(normal.normalize().abs_diff_eq(Vec3::Y, 1e-5));
        assert!(0.5 < area / (0.1 * 0.05) && area / (0.1 * 0.05) < 0.7);
        assert_eq!(leaf.triangles.len(), 28);
    }

    #[test]
    fn bending_keeps_the_area_of_a_leaf_nearly() {
        let (flat, _) = area_and_mean_normal(&leaf(0.1, 0.05, 0.0, 0.0));
        let (bent, _) = area_and_mean_normal(&leaf(0.1, 0.05, 1.0, 0.0));
        let (folded, _) = area_and_mean_normal(&leaf(0.1, 0.05, 0.0, 0.5));
        assert!((bent / flat - 1.0).abs() < 0.01);
        assert!((folded / flat - 1.0).abs() < 0.01);
    }
}
