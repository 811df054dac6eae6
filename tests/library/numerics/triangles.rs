//! Triangles that are hardly triangles: needles, repeated vertices, no area; and triangles that lie in
//! one another.

use crate::numerics::compare::{SlicePlan, by_slices, per_ray};
use crate::numerics::scenes::empty;
use crate::numerics::scenes::{
    Frame, HIGH_SUN, LAMP, Lamp, add_instance, add_mesh, add_triangles, fog, grove, leaf, light, spread,
    vector,
};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use sunfleck::math::Sampler;
use sunfleck::scene::{Scene, Size};

const SIZE: Size = Size { width: 64, height: 64 };

fn hold(name: &str, scene: &Scene, bound: f64) {
    per_ray(scene, 1.0, spread(400)).hold(&format!("{name}, per ray"), bound);
    by_slices(scene, &SlicePlan::even(SIZE, 19, 21)).hold(&format!("{name}, slices"), bound);
}

fn foggy(lamp: Lamp, fill: impl Fn(&mut Scene)) -> Scene {
    let mut scene = empty(&Frame::HERE);
    fill(&mut scene);
    fog(&mut scene, &Frame::HERE, DVec3::new(-6.0, -3.0, -9.0), DVec3::new(6.0, 4.0, 1.0), 0.2, 0.3);
    light(&mut scene, &Frame::HERE, lamp);
    scene
}

/// A thousand times as long as wide, a million times, and everything between.
#[test]
fn needles() {
    for lamp in [HIGH_SUN, LAMP] {
        for thinness in [1e-3_f32, 1e-6] {
            let scene = foggy(lamp, |scene| {
                let needles: Vec<[Vec3; 3]> = (0..200)
                    .map(|number| {
                        let mut random = Sampler::new(3, number, 0, 0);
                        let from =
                            (vector(&mut random) * DVec3::new(3.0, 2.0, 2.0) - 5.0 * DVec3::Z).as_vec3();
                        let along = vector(&mut random).as_vec3();
                        let across = thinness * along.length() * vector(&mut random).as_vec3();
                        [from, from + along, from + 0.5 * along + across]
                    })
                    .collect();
                add_triangles(scene, &Frame::HERE, &needles);
            });
            hold(&format!("needles 1:{thinness:e}, {lamp:?}"), &scene, 1e-6);
        }
    }
}

/// What has no area is not there: the same bits with and without.
#[test]
fn without_area() {
    for lamp in [HIGH_SUN, LAMP] {
        let mut scene = grove(&Frame::HERE, lamp);
        let nothing: Vec<[Vec3; 3]> = (0..300)
            .map(|number| {
                let mut random = Sampler::new(4, number, 0, 0);
                let at = |random: &mut Sampler| (2.0 * vector(random) - 4.0 * DVec3::Z).as_vec3();
                let (a, b) = (at(&mut random), at(&mut random));
                match number % 4 {
                    0 => [a, a, a],
                    1 => [a, a, b],
                    2 => [a, b, a],
                    // In a line, exactly.
                    _ => [a, a + Vec3::new(0.0, 0.5, 0.0), a + Vec3::new(0.0, 0.25, 0.0)],
                }
            })
            .collect();
        add_triangles(&mut scene, &Frame::HERE, &nothing);
        hold(&format!("without area, {lamp:?}"), &scene, 1e-6);
    }
}

/// Every leaf twice: the second time as a copy, as a copy of a copy's bits, or divided otherwise.
#[test]
fn twice_the_same_leaf() {
    for lamp in [HIGH_SUN, LAMP] {
        let scene = foggy(lamp, |scene| {
            let (positions, triangles) = leaf();
            let other_diagonal: Vec<[u32; 3]> = triangles
                .chunks(2)
                .flat_map(|t| [[t[0][0], t[0][1], t[1][2]], [t[0][1], t[0][2], t[1][2]]])
                .collect();
            let mesh = add_mesh(scene, positions.clone(), &triangles);
            let turned_round: Vec<[u32; 3]> = triangles.iter().map(|t| [t[1], t[0], t[2]]).collect();
            let mirrored = add_mesh(scene, positions.clone(), &turned_round);
            let flat: Vec<Vec3> = positions.iter().map(|p| Vec3::new(p.x, 0.0, p.z)).collect();
            let flat_one = add_mesh(scene, flat.clone(), &triangles);
            let flat_other = add_mesh(scene, flat, &other_diagonal);
            for number in 0..12 {
                let mut random = Sampler::new(6, number, 0, 0);
                let at = vector(&mut random) * DVec3::new(3.0, 1.5, 2.0) - 5.0 * DVec3::Z;
                let turn = DQuat::from_scaled_axis(3.0 * vector(&mut random));
                let placed = DAffine3::from_rotation_translation(turn, at);
                let pairs = [[mesh, mesh], [mesh, mirrored], [flat_one, flat_other]];
                for mesh in pairs[number as usize % 3] {
                    add_instance(scene, mesh, &Frame::HERE, placed);
                }
            }
        });
        hold(&format!("twice the same leaf, {lamp:?}"), &scene, 1e-6);
    }
}

/// Two leaves of different size and turn in one plane, which no axis is parallel to.
#[test]
fn leaves_in_one_plane() {
    for lamp in [HIGH_SUN, LAMP] {
        let scene = foggy(lamp, |scene| {
            let (positions, triangles) = leaf();
            let flat: Vec<Vec3> = positions.iter().map(|p| Vec3::new(p.x, 0.0, p.z)).collect();
            let mesh = add_mesh(scene, flat, &triangles);
            for number in 0..10 {
                let mut random = Sampler::new(7, number, 0, 0);
                let at = vector(&mut random) * DVec3::new(3.0, 1.5, 2.0) - 5.0 * DVec3::Z;
                let plane = DAffine3::from_rotation_translation(
                    DQuat::from_scaled_axis(3.0 * vector(&mut random)),
                    at,
                );
                for (turn, scale) in [(0.0, 1.0), (1.1, 1.7), (2.9, 0.6)] {
                    let within = DAffine3::from_scale_rotation_translation(
                        DVec3::splat(scale),
                        DQuat::from_rotation_y(turn),
                        DVec3::new(0.1 * turn, 0.0, 0.05),
                    );
                    add_instance(scene, mesh, &Frame::HERE, plane * within);
                }
            }
        });
        hold(&format!("leaves in one plane, {lamp:?}"), &scene, 1e-6);
    }
}
