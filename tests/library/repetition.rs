//! Whether one sees leaves of `title` twice: leaves beside each other that look alike, and
//! leaves that move in step.
//!
//! `cargo test --test library repetition:: -- --nocapture` prints the figures of docs/gallery/README.md.

use crate::checkout;
use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::LazyLock;
use sunfleck::color::Rgb;
use sunfleck::description;
use sunfleck::scene::{self, Material, Mesh, Scene, TextureIndex};
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};

/// The frame of the gallery, in which leaves are looked at, and the sequence's others, in which they move.
const FRAME: u32 = 24;
const FRAMES: std::ops::RangeInclusive<u32> = 1..=48;
const FRAMES_PER_S: f64 = 24.0;
/// Half the picture's size.
const PICTURE: (usize, usize) = (960, 540);
/// Leaves that are this near to each other, in heights of the picture, are compared by an eye.
const NEAR: f64 = 0.25;
/// Two leaves are alike if their points are less than this apart, in parts of a leaf's size
/// (root mean squares) ...
const ALIKE_SHAPE: f64 = 0.15;
/// ... and their colours less than this, in parts of themselves.
const ALIKE_COLOR: f64 = 0.1;

/// Two leaves are in step if their velocities are less than this apart, in parts of how much all vary; or a
/// bit more, if their turns are, too.
const IN_STEP: f64 = 0.1;
const IN_STEP_AND_TURN: f64 = 0.25;

/// The scene, and what is seen of its leaves, the largest first.
static TITLE: LazyLock<(Scene, Vec<Look>)> = LazyLock::new(|| {
    let path = checkout::file("scenes/title/scene.ron");
    let (scene, _) = scene::resolve(description::load(&path).unwrap(), None).unwrap();
    let looks = looks(&scene);
    (scene, looks)
});

/// What an eye sees of a leaf.
struct Look {
    name: String,
    node: usize,
    species: String,
    /// Where it is in the picture, in heights of it.
    place: DVec2,
    pixels: usize,
    /// The same points of all leaves of its species, as they lie in the picture about their
    /// middle; root mean square 1.
    shape: Vec<DVec2>,
    /// Of the light that it reflects and lets through.
    color: Rgb,
}

impl Look {
    /// `maple 1 crown` of `maple 1 crown.17`.
    fn block(&self) -> &str {
        self.name.split('.').next().unwrap()
    }

    fn is_near(&self, other: &Self) -> bool {
        self.place.distance(other.place) < NEAR
    }

    fn is_like(&self, other: &Self) -> bool {
        let squares = self.shape.iter().zip(&other.shape).map(|(a, b)| a.distance_squared(*b));
        let shapes_apart = (squares.sum::<f64>() / self.shape.len() as f64).sqrt();
        let colors_apart =
            2.0 * (self.color - other.color).length() / (self.color.length() + other.color.length());
        shapes_apart < ALIKE_SHAPE && colors_apart < ALIKE_COLOR
    }
}

fn seconds(frame: u32) -> f64 {
    f64::from(frame) / FRAMES_PER_S
}

/// Where a place in the texture lies on a leaf: in the triangle that holds it or comes nearest to that. Also
/// the least weight that one of its vertices has there, below 0 if none holds it.
fn on_leaf(mesh: &Mesh, at: Vec2) -> (DVec3, f64) {
    let at = at.as_dvec2();
    let places = mesh.triangles.iter().filter_map(|triangle| {
        let [a, b, c] = triangle.vertices.map(|vertex| mesh.uvs[vertex as usize].as_dvec2());
        let parts = [(b - at).perp_dot(c - at), (c - at).perp_dot(a - at), (a - at).perp_dot(b - at)];
        let weights = parts.map(|part| part / parts.iter().sum::<f64>());
        let corners = triangle.vertices.map(|vertex| mesh.positions[vertex as usize].as_dvec3());
        let point = corners.into_iter().zip(weights).map(|(corner, weight)| weight * corner).sum();
        let least = weights.into_iter().fold(f64::INFINITY, f64::min);
        least.is_finite().then_some((point, least))
    });
    places.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

/// Reflected and let through, on the average, by the mean of each texture.
fn color(means: &[Rgb], material: &Material) -> Rgb {
    let mean = |texture: Option<TextureIndex>| texture.map_or(Rgb::ONE, |index| means[index]);
    material.base_color * mean(material.base_color_texture)
        + material.transmission * mean(material.transmission_texture.map(|map| map.texture))
}

/// Pixels that show each instance, and where they lie on the average, in heights of the picture.
fn seen(scene: &Scene) -> BTreeMap<u32, (usize, DVec2)> {
    let trees = MeshTrees::new(scene);
    let (width, height) = (PICTURE.0 as f64, PICTURE.1 as f64);
    let snapshot = Snapshot::new(scene, &trees, 0, width / height, Shutter::instant(seconds(FRAME)));
    let mut seen: BTreeMap<u32, (usize, DVec2)> = BTreeMap::new();
    for pixel in 0..PICTURE.0 * PICTURE.1 {
        let place = DVec2::new((pixel % PICTURE.0) as f64 + 0.5, (pixel / PICTURE.0) as f64 + 0.5);
        let mut ray = snapshot.view.ray(place.x / width, place.y / height);
        let mut hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None);
        // Behind leaves that shade alone.
        while let Some(unseen) = hit.filter(|hit| !snapshot.is_seen(hit.primitive)) {
            ray.origin = ray.at(unseen.t);
            hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, Some(unseen.primitive));
        }
        if let Some(hit) = hit {
            let (pixels, sum) = seen.entry(snapshot.surface(&ray, &hit).leaf_id).or_default();
            (*pixels, *sum) = (*pixels + 1, *sum + place / height);
        }
    }
    seen.values_mut().for_each(|(pixels, sum)| *sum /= *pixels as f64);
    seen
}

/// The leaves that are seen, the largest first.
fn looks(scene: &Scene) -> Vec<Look> {
    let seen = seen(scene);
    let placements = scene.placements(seconds(FRAME));
    let camera_from_world = placements[scene.cameras[0].node].world_from_node.inverse();
    // Many materials are tints of one texture.
    let means: Vec<Rgb> = scene
        .textures
        .iter()
        .map(|texture| {
            let sum: Rgb = texture.texels.iter().map(|[r, g, b, _]| Vec3::new(r, g, b).as_dvec3()).sum();
            sum / texture.texels.len() as f64
        })
        .collect();
    let colors: Vec<Rgb> = scene.materials.iter().map(|material| color(&means, material)).collect();
    // Of each species, places in its texture that lie on it; of each mesh, where they are.
    let (mut places, mut points) = (BTreeMap::<&str, Vec<Vec2>>::new(), BTreeMap::<usize, Vec<DVec3>>::new());
    let mut looks = Vec::new();
    for leaf in &scene.instances {
        let mesh = &scene.meshes[leaf.mesh];
        // Leaves' meshes are called `maple, near a`; wood and grounds have no comma.
        let (Some((species, _)), Some(&(pixels, place))) =
            (mesh.name.split_once(", "), seen.get(&leaf.leaf_id))
        else {
            continue;
        };
        let places = places.entry(species).or_insert_with(|| {
            let cell = |cell: usize| Vec2::new((cell % 12) as f32 + 0.5, (cell / 12) as f32 + 0.5) / 12.0;
            (0..144).map(cell).filter(|&at| on_leaf(mesh, at).1 >= 0.0).collect()
        });
        let points =
            points.entry(leaf.mesh).or_insert_with(|| places.iter().map(|&at| on_leaf(mesh, at).0).collect());
        let camera_from_leaf: DAffine3 = camera_from_world * placements[leaf.node].world_from_node;
        let middle = camera_from_leaf.transform_point3(points.iter().sum::<DVec3>() / points.len() as f64);
        // As the eye sees it that looks straight at the leaf.
        let turn = DQuat::from_rotation_arc(middle.normalize(), DVec3::NEG_Z);
        let shape: Vec<DVec2> = points
            .iter()
            .map(|&point| (turn * (camera_from_leaf.transform_point3(point) - middle)).truncate())
            .collect();
        let size = (shape.iter().map(|p| p.length_squared()).sum::<f64>() / shape.len() as f64).sqrt();
        looks.push(Look {
            name: scene.nodes[leaf.node].name.clone(),
            node: leaf.node,
            species: species.to_owned(),
            place,
            pixels,
            shape: shape.into_iter().map(|point| point / size).collect(),
            color: colors[leaf.material.unwrap()],
        });
    }
    looks.sort_by_key(|look| Reverse(look.pixels));
    looks
}

/// All pairs of two leaves.
fn pairs<T>(leaves: &[T]) -> impl Iterator<Item = (&T, &T)> {
    leaves.iter().enumerate().flat_map(|(number, a)| leaves[..number].iter().map(move |b| (a, b)))
}

fn root_mean_square(values: impl Iterator<Item = DVec3>) -> f64 {
    let (sum, count) =
        values.fold((0.0, 0.0), |(sum, count), value| (sum + value.length_squared(), count + 1.0));
    (sum / count).sqrt()
}

/// By how much the velocities of two leaves differ, in parts of how much they all vary: of each pair.
fn apart(ways: &[Vec<DVec3>]) -> Vec<f64> {
    let all = || ways.iter().flatten().copied();
    let mean = all().sum::<DVec3>() / all().count() as f64;
    let spread = root_mean_square(all().map(|velocity| velocity - mean));
    pairs(ways).map(|(a, b)| root_mean_square(a.iter().zip(b).map(|(a, b)| a - b)) / spread).collect()
}

#[test]
fn leaves_side_by_side_are_not_alike() {
    let looks = &TITLE.1;
    for (count, most_per_mille) in [(30, 0.0), (100, 15.0), (300, 5.0), (1000, 2.5)] {
        let leaves = &looks[..count];
        let of_a_species = || pairs(leaves).filter(|(a, b)| a.species == b.species);
        let near: Vec<_> = of_a_species().filter(|(a, b)| a.is_near(b)).collect();
        let alike = near.iter().filter(|(a, b)| a.is_like(b)).count();
        // What neighbours have in common by chance: as much as leaves of their two blocks
        // that are no neighbours.
        let mut far: BTreeMap<_, (f64, f64)> = BTreeMap::new();
        for (a, b) in of_a_species().filter(|(a, b)| !a.is_near(b)) {
            let (pairs, alike) = far.entry((a.block(), b.block())).or_default();
            (*pairs, *alike) = (*pairs + 1.0, *alike + f64::from(u8::from(a.is_like(b))));
        }
        let by_chance = |(a, b): &(&Look, &Look)| far.get(&(a.block(), b.block())).map_or(0.0, |f| f.1 / f.0);
        let chance: f64 = near.iter().map(by_chance).sum();
        println!(
            "of the {count} largest leaves, {} pixels and more: {} pairs of neighbours of a species, {alike} alike ({:.1} per mille), \
             {chance:.1} were they strangers",
            leaves[count - 1].pixels,
            near.len(),
            1000.0 * alike as f64 / near.len() as f64
        );
        assert!(alike as f64 <= most_per_mille * 1e-3 * near.len() as f64, "{alike} of {}", near.len());
    }
}

#[test]
fn no_two_leaves_move_in_step() {
    let (scene, looks) = &*TITLE;
    let placements: Vec<_> = FRAMES.map(|frame| scene.placements(seconds(frame))).collect();
    let (mut movers, mut steps, mut turns) = (Vec::new(), Vec::new(), Vec::new());
    for look in looks {
        let poses =
            placements.iter().map(|all| all[look.node].world_from_node.to_scale_rotation_translation());
        let poses: Vec<_> = poses.map(|(_, turn, place)| (turn, place)).collect();
        let step = |pair: &[(DQuat, DVec3)]| FRAMES_PER_S * (pair[1].1 - pair[0].1);
        let turn = |pair: &[(DQuat, DVec3)]| {
            let turn = pair[1].0 * pair[0].0.inverse();
            FRAMES_PER_S * (if turn.w < 0.0 { -turn } else { turn }).to_scaled_axis()
        };
        if poses.windows(2).any(|pair| step(pair) != DVec3::ZERO) {
            steps.push(poses.windows(2).map(step).collect());
            turns.push(poses.windows(2).map(turn).collect());
            movers.push(look);
        }
        if movers.len() == 100 {
            break;
        }
    }
    let found: Vec<_> = pairs(&movers).zip(apart(&steps).into_iter().zip(apart(&turns))).collect();
    for (what, limit, measure) in [
        ("travel", IN_STEP, (|(step, _)| step) as fn((f64, f64)) -> f64),
        ("travel and turn", IN_STEP_AND_TURN, |(step, turn)| step.max(turn)),
    ] {
        let least = found.iter().min_by(|a, b| measure(a.1).total_cmp(&measure(b.1))).unwrap();
        let ((a, b), apart) = (least.0, measure(least.1));
        println!(
            "of {} leaves that move the two that {what} most alike, `{}` and `{}`: {:.0} % of all their spread apart",
            movers.len(),
            a.name,
            b.name,
            100.0 * apart
        );
        assert!(apart > limit, "`{}` and `{}` {what} by {apart} of their spread apart", a.name, b.name);
    }
}
