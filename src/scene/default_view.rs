//! Default camera: a three-quarter view that tightly frames everything in all frames. In go a scene, its
//! frames and the picture's aspect, out comes the camera's place. Invariant: it is fixed, and depends on the
//! whole range of frames. So a frame rendered alone equals that of the sequence.

use super::{Camera, Clip, Instance, Lens, Motion, Placement, RenderSettings, Scene, Track};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::ops::RangeInclusive;

const NAME: &str = "camera";

/// Vertical field of view, radians.
const FOV_Y: f64 = 0.7;

/// Azimuth to the right from the front (+Z, which glTF's models face), and elevation.
const AZIMUTH_DEG: f64 = 38.0;
const ELEVATION_DEG: f64 = 22.0;

/// Margin: size of the picture over that of its contents.
const MARGIN: f64 = 1.12;

/// Minimum distance of everything, relative to the extent of all.
const NEAREST: f64 = 0.1;

/// Maximum number of moments to sample, and of triangles' corners over all of them. The first and last moment
/// are always sampled.
const MOST_MOMENTS: usize = 25;
const MOST_CORNERS: usize = 40_000_000;

/// Cost of deforming a mesh, in visits of its corners.
const BENDING: usize = 8;

/// Adds a camera without a place if the scene has none; returns whether it did.
pub(super) fn add(scene: &mut Scene) -> bool {
    let is_missing = scene.cameras.is_empty();
    if is_missing {
        let name = String::from(NAME);
        let node = scene.add_node(name.clone(), None, Motion::STILL);
        let lens = Lens::Perspective { fov_y: Track::from(FOV_Y) };
        scene.cameras.push(Camera { name, node, lens, shift: DVec2::ZERO, aperture: None, clip: Clip::NONE });
    }
    is_missing
}

/// Places the camera of [`add`] where it sees everything in the settings' frames.
pub(super) fn aim(scene: &mut Scene, settings: &RenderSettings) {
    let frustum = Frustum::three_quarters(settings.size.width as f64 / settings.size.height as f64);
    let moments = moments(scene, &settings.frames).map(|frame| settings.frame_rate.seconds(frame));
    let seen = moments.map(|time_s| seen_at(scene, time_s, &frustum));
    let (position, target) = seen.fold(Seen::NOTHING, Seen::and).fitted(&frustum);
    let motion = Motion::Aimed { position: position.into(), target: target.into(), up: DVec3::Y.into() };
    scene.nodes[scene.cameras[0].node].motion = motion;
}

/// Evenly spaced moments of the range, the first and last frame included.
fn moments(scene: &Scene, frames: &RangeInclusive<i64>) -> impl Iterator<Item = f64> + use<> {
    let corners = |instance: &Instance| {
        let corners = 3 * scene.meshes[instance.mesh].triangles.len();
        if instance.deformation.is_some() { BENDING * corners } else { corners }
    };
    let corners: usize = scene.instances.iter().map(corners).sum();
    let affordable = (MOST_CORNERS / corners.max(1)).clamp(2, MOST_MOMENTS) as i64;
    let (first, last) = (*frames.start(), *frames.end());
    let steps = if scene.is_still() { 0 } else { (last - first).min(affordable - 1) };
    let part = move |step: i64| if steps == 0 { 0.0 } else { step as f64 / steps as f64 };
    (0..=steps).map(move |step| first as f64 + part(step) * (last - first) as f64)
}

/// Frustum of a camera without the margin: its axes in world space, and the tangents of half its angles.
struct Frustum {
    right: DVec3,
    up: DVec3,
    backward: DVec3,
    tangents: DVec2,
}

impl Frustum {
    /// Three-quarter frustum of a picture; `aspect` is width / height.
    fn three_quarters(aspect: f64) -> Self {
        let (sin_azimuth, cos_azimuth) = AZIMUTH_DEG.to_radians().sin_cos();
        let (sin_elevation, cos_elevation) = ELEVATION_DEG.to_radians().sin_cos();
        let backward = DVec3::new(sin_azimuth * cos_elevation, sin_elevation, cos_azimuth * cos_elevation);
        let right = DVec3::new(cos_azimuth, 0.0, -sin_azimuth);
        let tangents = DVec2::new(aspect, 1.0) * (0.5 * FOV_Y).tan() / MARGIN;
        Self { right, up: backward.cross(right), backward, tangents }
    }

    /// Point of the world in the camera's axes.
    fn in_axes(&self, world: DVec3) -> DVec3 {
        DVec3::new(world.dot(self.right), world.dot(self.up), world.dot(self.backward))
    }
}

/// Bounds of the contents for a camera with fixed axes.
#[derive(Clone, Copy)]
struct Seen {
    /// Support across the sides of a frustum at the origin: right, left, top, bottom.
    sides: [f64; 4],
    /// Smallest and largest coordinates along the camera's axes.
    low: DVec3,
    high: DVec3,
}

impl Seen {
    const NOTHING: Self =
        Self { sides: [f64::NEG_INFINITY; 4], low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// Bounds of a point in the camera's axes. A frustum with its apex at `a` contains the point `p` if
    /// |p.x - a.x| <= t.x (a.z - p.z), and likewise in y. So only the points farthest across each of the
    /// four sides matter.
    fn point(p: DVec3, tangents: DVec2) -> Self {
        let deep = tangents * p.z;
        Self { sides: [p.x + deep.x, -p.x + deep.x, p.y + deep.y, -p.y + deep.y], low: p, high: p }
    }

    fn and(self, other: Self) -> Self {
        let sides = [0, 1, 2, 3].map(|side| self.sides[side].max(other.sides[side]));
        Self { sides, low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Position of the camera, and its target.
    fn fitted(self, frustum: &Frustum) -> (DVec3, DVec3) {
        let tangents = frustum.tangents;
        let seen = if self.low.x <= self.high.x { self } else { Self::unit_cube(tangents) };
        let [right, left, top, bottom] = seen.sides;
        let extent = (seen.high - seen.low).length().max(1e-3);
        let far = (0.5 * (right + left) / tangents.x).max(0.5 * (top + bottom) / tangents.y);
        // A single point, or a line towards the camera, fits at any distance.
        let far = far.max(seen.high.z + NEAREST * extent);
        let world = |x: f64, y: f64, z: f64| x * frustum.right + y * frustum.up + z * frustum.backward;
        let (x, y) = (0.5 * (right - left), 0.5 * (top - bottom));
        (world(x, y, far), world(x, y, 0.5 * (seen.low.z + seen.high.z)))
    }

    /// Bounds of a cube around the origin, for empty scenes.
    fn unit_cube(tangents: DVec2) -> Self {
        let corner = |sign: f64| Self::point(DVec3::splat(0.5 * sign), tangents);
        corner(1.0).and(corner(-1.0))
    }
}

fn seen_at(scene: &Scene, time_s: f64, frustum: &Frustum) -> Seen {
    let placements = scene.placements(time_s);
    let seen = |instance: &Instance| {
        let Placement { visible, world_from_node } = placements[instance.node];
        let is_flattened = instance.deformation.is_none() && world_from_node.matrix3.determinant() == 0.0;
        if !visible || is_flattened {
            return Seen::NOTHING;
        }
        let (positions, world_from_mesh) = scene.vertices(instance, &placements, time_s);
        // Vertices without triangles do not count.
        let corners = scene.meshes[instance.mesh].triangles.iter().flat_map(|triangle| triangle.vertices);
        let places = corners.map(|vertex| {
            frustum.in_axes(world_from_mesh.transform_point3(positions[vertex as usize].as_dvec3()))
        });
        places
            .filter(|place| place.is_finite())
            .fold(Seen::NOTHING, |seen, place| seen.and(Seen::point(place, frustum.tangents)))
    };
    scene.instances.par_iter().map(seen).reduce(|| Seen::NOTHING, Seen::and)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Extend, Key, Mesh, Node, Rotation, Segment, Size, Triangle};
    use glam::{DAffine3, DQuat, DVec4, Vec3};

    /// Two triangles of 2x1 m, at nodes that move as they are told; one a node.
    fn scene(motions: Vec<Motion>) -> Scene {
        let positions = [(-1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
        // A vertex that no triangle has lies far away.
        let positions = [&positions[..], &[Vec3::splat(1e3)]].concat();
        let triangles = [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material: 0 });
        let mesh = Mesh { positions, triangles: triangles.to_vec(), ..Mesh::default() };
        let instance = |node| Instance { node, mesh: 0, material: None, leaf_id: 1, deformation: None };
        let instances = (0..motions.len()).map(instance).collect();
        let node = |motion| Node { name: String::new(), parent: None, motion, visible: Track::from(true) };
        let nodes = motions.into_iter().map(node).collect();
        Scene { nodes, instances, meshes: vec![mesh], ..Scene::default() }
    }

    fn settings(width: usize, height: usize, last: i64) -> RenderSettings {
        RenderSettings { size: Size { width, height }, frames: 1..=last, ..RenderSettings::default() }
    }

    fn at(place: DVec3) -> Motion {
        Motion::Still(DAffine3::from_translation(place))
    }

    /// Offsets of corners from the picture's middle at a frame, right and up, in halves of its width and
    /// height; all must be before the camera.
    fn places(scene: &Scene, settings: &RenderSettings, frame: f64) -> Vec<DVec2> {
        let time_s = settings.frame_rate.seconds(frame);
        let placements = scene.placements(time_s);
        let aspect = settings.size.width as f64 / settings.size.height as f64;
        let camera = &scene.cameras[0];
        let camera_from_world = placements[camera.node].world_from_node.inverse();
        let projection = camera.projection(aspect, time_s);
        let corners = scene.instances.iter().flat_map(|instance| {
            let (positions, world) = scene.vertices(instance, &placements, time_s);
            (0..4).map(move |vertex| world.transform_point3(positions[vertex].as_dvec3()))
        });
        let project = |corner| {
            let clip: DVec4 = projection * camera_from_world.transform_point3(corner).extend(1.0);
            assert!(clip.w > 0.0, "{corner} lies behind the camera");
            DVec2::new(clip.x, clip.y) / clip.w
        };
        corners.map(project).collect()
    }

    fn reach(places: &[DVec2]) -> DVec2 {
        places.iter().fold(DVec2::ZERO, |reach, place| reach.max(place.abs()))
    }

    fn seen(mut scene: Scene, settings: &RenderSettings) -> Scene {
        assert!(add(&mut scene));
        aim(&mut scene, settings);
        scene
    }

    /// Whatever the picture's shape and wherever things are, the farthest corner keeps
    /// the margin and no more.
    #[test]
    fn the_picture_is_filled_to_the_margin_in_every_shape() {
        for (width, height) in [(960, 540), (540, 960), (100, 100), (1000, 10)] {
            for offset in [0.3, 40.0, 1e6] {
                let settings = settings(width, height, 1);
                let placed = vec![at(DVec3::splat(offset)), at(DVec3::new(3.0, 2.0, -1.0) + offset)];
                let scene = seen(scene(placed), &settings);
                let reach = reach(&places(&scene, &settings, 1.0)).max_element();
                assert!((reach * MARGIN - 1.0).abs() < 1e-6, "{width}x{height}, {offset}: {reach}");
            }
        }
    }

    #[test]
    fn it_looks_from_the_right_and_above_at_a_front() {
        let settings = settings(16, 9, 1);
        let scene = seen(scene(vec![at(DVec3::ZERO)]), &settings);
        let backward = scene.placements(0.0)[scene.cameras[0].node].world_from_node.matrix3.z_axis;
        assert!(backward.abs_diff_eq(Frustum::three_quarters(1.0).backward, 1e-9), "{backward}");
        assert!(backward.z > 0.6 && backward.x > 0.4 && (0.3..0.5).contains(&backward.y), "{backward}");
    }

    /// It rises by 12 m over frames 1 to 49: one camera sees it at the first, in the middle and at the last.
    #[test]
    fn all_frames_of_the_range_are_seen_and_those_beyond_are_not_waited_for() {
        let key = |time_s, height| Key { time_s, value: DVec3::Y * height, to_next: Segment::Linear };
        let keys = vec![key(1.0 / 24.0, 0.0), key(49.0 / 24.0, 12.0)];
        let translation = Track::new(keys, Extend::Hold).expect("keys in order");
        let rotation = Rotation::Quaternion(Track::from(DQuat::IDENTITY));
        let rising = || {
            vec![Motion::Keyed {
                translation: translation.clone(),
                rotation: rotation.clone(),
                scale: DVec3::ONE.into(),
            }]
        };
        let whole = settings(16, 9, 49);
        let scene_whole = seen(scene(rising()), &whole);
        for frame in [1.0, 13.5, 25.0, 49.0] {
            let reach = reach(&places(&scene_whole, &whole, frame));
            assert!(reach.max_element() <= 1.0 / MARGIN + 1e-9, "{frame}: {reach}");
        }
        let beginning = settings(16, 9, 2);
        let near = seen(scene(rising()), &beginning);
        let distance =
            |scene: &Scene| scene.placements(0.0)[scene.cameras[0].node].world_from_node.translation.length();
        assert!(distance(&near) < 0.5 * distance(&scene_whole));
        assert!(moments(&near, &(1..=49)).count() == MOST_MOMENTS && moments(&near, &(5..=7)).count() == 3);
        assert_eq!(moments(&near, &(1..=49)).last(), Some(49.0));
    }

    #[test]
    fn what_is_hidden_flattened_or_nowhere_does_not_count() {
        let settings = settings(16, 9, 1);
        let alone = seen(scene(vec![at(DVec3::ZERO)]), &settings);
        let flattened = Motion::Still(DAffine3::from_scale_rotation_translation(
            DVec3::ZERO,
            DQuat::IDENTITY,
            DVec3::splat(9.0),
        ));
        let nowhere = at(DVec3::splat(f64::INFINITY));
        let mut crowded = scene(vec![at(DVec3::ZERO), at(DVec3::splat(50.0)), flattened, nowhere]);
        crowded.nodes[1].visible = Track::from(false);
        let crowded = seen(crowded, &settings);
        let stands = |scene: &Scene| scene.placements(0.0)[scene.cameras[0].node].world_from_node;
        assert_eq!(stands(&alone), stands(&crowded));
    }

    #[test]
    fn empty_scenes_and_mere_points_have_a_camera_too() {
        let mut point = scene(vec![at(DVec3::splat(5.0))]);
        point.meshes[0].positions = vec![Vec3::ZERO; 5];
        for scene in [Scene::default(), point] {
            let scene = seen(scene, &settings(16, 9, 3));
            assert!(scene.placements(0.0)[scene.cameras[0].node].world_from_node.is_finite());
        }
    }

    #[test]
    fn a_scene_with_a_camera_keeps_it_alone() {
        let mut scene = seen(scene(vec![at(DVec3::ZERO)]), &settings(16, 9, 1));
        assert!(!add(&mut scene));
        assert_eq!((scene.cameras.len(), scene.nodes.len()), (1, 2));
    }
}
