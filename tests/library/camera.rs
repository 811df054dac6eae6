//! Lens and shutter against closed forms. How soft what is out of focus is, what is keyed, and when
//! the shutter is open.

use crate::common::{camera_at, place};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::PI;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{
    Animate, Aperture, Extend, FrameRate, Instance, Key, Lens, Material, Mesh, Motion, RenderSettings,
    Segment, Track, Triangle,
};
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};

fn keyed<T: Animate>(from: T, to: T) -> Track<T> {
    let key = |time_s: f64, value: T| Key { time_s, value, to_next: Segment::Linear };
    Track::new(vec![key(0.0, from), key(1.0, to)], Extend::Hold).expect("good keys")
}

/// The share of the lens that sees a wall 4 m away, which ends at the vertical plane x = 0, in the middle row
/// of the picture, `tangent` to the right of the axis; focus is pulled from the wall to 2 m within a second.
fn share(time_s: f64, blades: u32, tangent: f64) -> f64 {
    let mut scene = camera_at(DVec3::ZERO);
    // A right angle and a sensor of 36 mm: a focal length of 18 mm, and a lens of 0.5 m to either side.
    scene.cameras[0].aperture = Some(Aperture {
        f_stop: 0.018.into(),
        sensor_width_m: 0.036,
        focus_distance_m: keyed(4.0, 2.0),
        blades,
    });
    let node = place(&mut scene, DAffine3::from_translation(-4.0 * DVec3::Z));
    scene.materials.push(Material::default());
    scene.meshes.push(Mesh {
        positions: [
            DVec2::new(-99.0, -99.0),
            DVec2::new(0.0, -99.0),
            DVec2::new(0.0, 99.0),
            DVec2::new(-99.0, 99.0),
        ]
        .map(|corner| corner.extend(0.0).as_vec3())
        .to_vec(),
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material: 0 }).to_vec(),
        ..Mesh::default()
    });
    scene.instances.push(Instance { node, mesh: 0, material: None, leaf_id: 1, deformation: None });
    let shutter = Shutter { open_s: time_s, close_s: time_s };
    let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, shutter);
    let count = 1 << 12;
    let meets = |index: u32| {
        let lens_point = snapshot.view.lens_point(Sampler::new(3, 0, 0, index).next_2d().into());
        let Ray { origin, direction } = snapshot.view.ray_from(lens_point, 0.5 + 0.5 * tangent, 0.5);
        snapshot.tree.nearest_hit(&Ray { origin, direction }, f64::INFINITY, None).is_some()
    };
    f64::from((0..count).filter(|&index| meets(index)).count() as u32) / f64::from(count)
}

/// From a point l of the lens a ray meets the wall's plane at l (1 - 4 / F) + 4 tan: focused at 2 m, from all
/// points to the right of 4 tan it meets the wall.
#[test]
fn an_edge_out_of_focus_is_as_soft_as_the_lens_is_wide() {
    for tangent in [-0.11, -0.05, 0.0, 0.03, 0.1] {
        let c: f64 = 4.0 * tangent / 0.5;
        // The part of a disc beyond a chord.
        let disc = (c.acos() - c * (1.0 - c * c).sqrt()) / PI;
        let found = share(1.0, 0, tangent);
        assert!((found - disc).abs() < 4e-3, "{tangent}: {found} {disc}");
        // The part of a square on its corner: 1 - (1 + c)^2 / 2 to the left of its middle.
        let square = if c < 0.0 { 1.0 - 0.5 * (1.0 + c).powi(2) } else { 0.5 * (1.0 - c).powi(2) };
        let found = share(1.0, 4, tangent);
        assert!((found - square).abs() < 4e-3, "{tangent}, four blades: {found} {square}");
        // Halfway, at 3 m: a third as soft.
        let c = (12.0 * tangent / 0.5).clamp(-1.0, 1.0);
        let disc = (c.acos() - c * (1.0 - c * c).sqrt()) / PI;
        let found = share(0.5, 0, tangent);
        assert!((found - disc).abs() < 4e-3, "{tangent}, focused at 3 m: {found} {disc}");
    }
    assert_eq!([-0.01, 0.01].map(|tangent| share(0.0, 0, tangent)), [1.0, 0.0], "sharp where it is in focus");
}

#[test]
fn lens_and_upward_direction_change_with_their_keys() {
    let mut scene = camera_at(DVec3::ZERO);
    scene.cameras[0].lens = Lens::Perspective { fov_y: keyed(0.5 * PI, PI / 3.0) };
    let node = scene.cameras[0].node;
    scene.nodes[node].motion = Motion::Aimed {
        position: DVec3::ZERO.into(),
        target: DVec3::NEG_Z.into(),
        up: keyed(DVec3::Y, DVec3::X),
    };
    let top = |time_s: f64| {
        let shutter = Shutter { open_s: time_s, close_s: time_s };
        Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, shutter).view.ray(0.5, 0.0).direction
    };
    assert!(top(0.0).distance(DVec3::new(0.0, 1.0, -1.0).normalize()) < 1e-12);
    let half = (75.0_f64 / 2.0).to_radians();
    let corner = DVec3::new(0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0);
    assert!(top(0.5).distance(half.sin() * corner - half.cos() * DVec3::Z) < 1e-12);
    assert!(top(1.0).distance(DVec3::new(0.5, 0.0, -0.75_f64.sqrt())) < 1e-12);
    assert!(!scene.is_still());
}

#[test]
fn a_shutter_opens_when_it_is_told() {
    let frame_rate = FrameRate { numerator: 10, denominator: 1 };
    for (shutter, shutter_position, open, close) in
        [(0.0, 0.0, 20.0, 20.0), (0.5, 0.0, 19.75, 20.25), (0.5, 0.5, 20.0, 20.5), (1.0, -0.5, 19.0, 20.0)]
    {
        let settings = RenderSettings { frame_rate, shutter, shutter_position, ..RenderSettings::default() };
        let Shutter { open_s, close_s } = Shutter::of(&settings, 20.0);
        assert!((10.0 * open_s - open).abs() < 1e-12 && (10.0 * close_s - close).abs() < 1e-12);
    }
}
