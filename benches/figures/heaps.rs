//! How many leaves that have fallen lie through each other.

use crate::checkout;
use glam::{DAffine3, DVec3};
use sunfleck::description;
use sunfleck::scene::{self, Motion, Rotation, Scene};

type Triangle = [DVec3; 3];

/// Long after the last has landed.
const AT_REST_S: f64 = 1e6;

/// A mesh in the world and its box.
struct Leaf {
    triangles: Vec<Triangle>,
    low: DVec3,
    high: DVec3,
}

/// Prints how many pairs go through each other, in a file or in the scenes with the most
/// leaves on the ground.
pub fn run(file: Option<&String>) {
    let shipped =
        ["autumn", "falling_leaves_long"].map(|name| checkout::file(format!("scenes/{name}/scene.ron")));
    for path in file.map_or(shipped.to_vec(), |file| vec![file.into()]) {
        let loaded = description::load(&path).unwrap();
        let leaves = fallen(&scene::resolve(loaded, None).unwrap().0);
        let (mut near, mut through) = (0, 0);
        // From west to east, so that few have to be looked at.
        for (at, leaf) in leaves.iter().enumerate() {
            for other in leaves[at + 1..].iter().take_while(|other| other.low.x <= leaf.high.x) {
                if boxes_meet((leaf.low, leaf.high), (other.low, other.high)) {
                    near += 1;
                    through += u32::from(meet(leaf, other));
                }
            }
        }
        println!(
            "{}: {} leaves, {near} pairs whose boxes meet, {through} that lie through each other",
            path.display(),
            leaves.len()
        );
    }
}

/// All leaves of `fall` blocks, sorted by where their boxes begin.
fn fallen(scene: &Scene) -> Vec<Leaf> {
    let leaves = scene.instances.iter().filter_map(|instance| {
        let Motion::Keyed { translation, rotation: Rotation::Quaternion(rotation), scale } =
            &scene.nodes[instance.node].motion
        else {
            return None;
        };
        let place = DAffine3::from_scale_rotation_translation(
            scale.at(AT_REST_S),
            rotation.at(AT_REST_S),
            translation.at(AT_REST_S),
        );
        let mesh = &scene.meshes[instance.mesh];
        let corner = |vertex: u32| place.transform_point3(mesh.positions[vertex as usize].as_dvec3());
        let triangles: Vec<Triangle> =
            mesh.triangles.iter().map(|triangle| triangle.vertices.map(corner)).collect();
        let corners = || triangles.iter().flatten().copied();
        let (low, high) =
            (corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max));
        Some(Leaf { triangles, low, high })
    });
    let mut leaves: Vec<Leaf> = leaves.collect();
    leaves.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    leaves
}

/// Whether an edge of one goes through a triangle of the other.
fn meet(a: &Leaf, b: &Leaf) -> bool {
    let near = |leaf: &Leaf, other: &Leaf| -> Vec<Triangle> {
        leaf.triangles
            .iter()
            .copied()
            .filter(|triangle| boxes_meet(bounds(triangle), (other.low, other.high)))
            .collect()
    };
    let (of_a, of_b) = (near(a, b), near(b, a));
    let pairs = of_a.iter().flat_map(|a| of_b.iter().map(move |b| (a, b)));
    let mut close = pairs.filter(|(a, b)| boxes_meet(bounds(a), bounds(b)));
    close.any(|(a, b)| pierces(a, b) || pierces(b, a))
}

fn bounds([a, b, c]: &Triangle) -> (DVec3, DVec3) {
    (a.min(*b).min(*c), a.max(*b).max(*c))
}

fn boxes_meet(a: (DVec3, DVec3), b: (DVec3, DVec3)) -> bool {
    a.0.cmple(b.1).all() && b.0.cmple(a.1).all()
}

/// Whether one of the first triangle's edges goes through the second.
fn pierces([a, b, c]: &Triangle, [p, q, r]: &Triangle) -> bool {
    let normal = (*q - *p).cross(*r - *p);
    let sides = [a, b, c].map(|corner| (*corner - *p).dot(normal));
    if sides.iter().all(|&side| side > 0.0) || sides.iter().all(|&side| side < 0.0) {
        return false;
    }
    [(0, 1), (1, 2), (2, 0)].into_iter().any(|(from, to)| {
        if sides[from] * sides[to] >= 0.0 {
            return false;
        }
        let ends = [a, b, c];
        let at = *ends[from] + (*ends[to] - *ends[from]) * (sides[from] / (sides[from] - sides[to]));
        let inside = |u: &DVec3, v: &DVec3| (*v - *u).cross(at - *u).dot(normal) >= 0.0;
        inside(p, q) && inside(q, r) && inside(r, p)
    })
}
