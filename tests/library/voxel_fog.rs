//! Fog by voxels: against sums of many steps, against fog in a box, and one way of finding its light against
//! others.

use crate::checkout;
use crate::common::{EXACT, INSTANT, add_fog, add_light, camera_at, place};
use glam::{DAffine3, DQuat, DVec3, IVec3};
use std::sync::Arc;
use sunfleck::color::Rgb;
use sunfleck::description;
use sunfleck::fog::{FogBank, Medium};
use sunfleck::math::{LitVoxels, Sampler, Voxels, VoxelsBuilder};
use sunfleck::scene::{
    self, Bounces, Fog, FogShape, FogVoxels, GridFrame, GridFrames, LightKind, Scene, Size, Track,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Snapshot};
use sunfleck::transport::{MarchSteps, Sample, Scratch, Transport, VolumeMethod, radiance};

/// A puff of 24 voxels across: soft, uneven, empty in a corner.
fn puff() -> Voxels {
    let mut builder = VoxelsBuilder::default();
    let value = |voxel: IVec3| {
        let from_middle = (voxel.as_dvec3() - 11.5) / 11.5;
        let uneven = 1.0 + 0.5 * (0.9 * voxel.as_dvec3()).sin().element_sum() / 3.0;
        (uneven * (1.0 - from_middle.length_squared()).max(0.0)) as f32
    };
    for brick in 0..27 {
        let first = 8 * IVec3::new(brick % 3, brick / 3 % 3, brick / 9);
        let voxels = (0..512).map(|place| value(first + IVec3::new(place >> 6, place >> 3 & 7, place & 7)));
        builder.add(first, voxels);
    }
    builder.built().expect("it holds something")
}

fn add_voxels(scene: &mut Scene, world_from_voxel: DAffine3, voxels: Voxels, density_per_m: Rgb) {
    let node = place(scene, world_from_voxel);
    scene.fogs.push(Fog {
        name: "puff".into(),
        node,
        shape: FogShape::Voxels(Box::new(GridFrames::new(
            "puff.vdb".into(),
            "density",
            vec![GridFrame::made(0.0, FogVoxels::plain(DAffine3::IDENTITY, voxels))],
        ))),
        density_per_m: Track::from(density_per_m),
        albedo: Track::from(Rgb::new(0.95, 0.9, 0.8)),
        anisotropy: Track::from(0.5),
    });
}

/// Turned, and longer than wide, five metres before the camera.
fn turned() -> DAffine3 {
    let turn = DQuat::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), 0.7);
    let scale = DVec3::new(0.1, 0.15, 0.12);
    DAffine3::from_translation(-5.0 * DVec3::Z)
        * DAffine3::from_scale_rotation_translation(scale, turn, DVec3::ZERO)
        * DAffine3::from_translation(DVec3::splat(-11.5))
}

fn lit_puff() -> Scene {
    puff_by(LightKind::Sun, DVec3::ZERO, Rgb::new(3.0, 2.0, 1.0))
}

fn puff_by(light: LightKind, position: DVec3, power: Rgb) -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    add_voxels(&mut scene, turned(), puff(), Rgb::new(0.6, 0.8, 1.2));
    add_light(&mut scene, light, position, DVec3::new(0.5, -0.7, -0.3), power);
    scene
}

fn seen(scene: &Scene, transport: &Transport, place: [f64; 2], seed: u32) -> Sample {
    let trees = MeshTrees::new(scene);
    let snapshot = Snapshot::new(scene, &trees, 0, 1.0, INSTANT);
    let ray = snapshot.view.ray(place[0], place[1]);
    radiance(&snapshot, transport, &ray, &mut Sampler::new(seed, 0, 0, 0), &mut Scratch::default())
}

/// Optical depths by 60,000 steps in double precision.
#[test]
fn optical_depths_are_those_of_many_steps() {
    let relative_from_voxel = turned();
    let voxels = puff();
    let voxel_from_relative = relative_from_voxel.inverse();
    let at = |point: DVec3| voxels.at(voxel_from_relative.transform_point3(point));
    let grid = Arc::new(LitVoxels::from(puff()));
    let bank = FogBank::of_voxels(relative_from_voxel, grid, Rgb::splat(1.2), Rgb::ONE, 0.0);
    let medium = Medium::new(vec![bank.expect("fog")]);
    let mut deepest = 0.0_f64;
    for number in 0..60 {
        let aim = DVec3::new(f64::from(number % 8) - 3.5, f64::from(number / 8) - 3.5, -14.0);
        let direction = aim.normalize();
        let (steps, length) = (60_000, 9.0);
        let width = length / f64::from(steps);
        let depth: f64 =
            (0..steps).map(|step| width * 1.2 * at((f64::from(step) + 0.5) * width * direction)).sum();
        let found = medium.optical_depth(DVec3::ZERO, direction, length).x;
        assert!((found - depth).abs() < 1e-6, "{direction}: {found} {depth}");
        deepest = deepest.max(found);
    }
    assert!(deepest > 1.0, "{deepest}");
}

/// Where voxels are 1 all over, and rays do not come near their rim, they are fog in a box.
#[test]
fn even_voxels_are_even_fog() {
    let (low, high) = (DVec3::new(-2.0, -2.0, -7.0), DVec3::new(2.0, 2.0, -3.0));
    let sun = |scene: &mut Scene| {
        add_light(scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.5, -0.7, -0.3), Rgb::new(3.0, 2.0, 1.0));
    };
    let mut boxed = camera_at(DVec3::ZERO);
    add_fog(&mut boxed, low, high, Rgb::splat(0.3), Rgb::new(0.95, 0.9, 0.8), 0.5);
    sun(&mut boxed);
    // A thousandth of the box a voxel would be too many: the rim is half a voxel to either side.
    let mut voxels = VoxelsBuilder::default();
    voxels.add_even(IVec3::ZERO, 128, 1.0).expect("it is small");
    let size = (high - low) / 128.0;
    let world_from_voxel = DAffine3::from_translation(low + 0.5 * size) * DAffine3::from_scale(size);
    let mut scene = camera_at(DVec3::ZERO);
    add_voxels(&mut scene, world_from_voxel, voxels.built().expect("fog"), Rgb::splat(0.3));
    sun(&mut scene);
    for place in [[0.5, 0.5], [0.45, 0.55], [0.4, 0.42]] {
        let (expected, found) = (seen(&boxed, &EXACT, place, 0), seen(&scene, &EXACT, place, 0));
        let off = (found.radiance / expected.radiance - 1.0).abs().max_element();
        assert!(off < 1e-3, "{place:?}: {} {}", found.radiance, expected.radiance);
    }
}

/// Rules cell by cell beside a march of so many steps that it is the truth.
#[test]
fn a_march_of_many_steps_finds_the_same_light() {
    let march = Transport { volume: VolumeMethod::March(MarchSteps::Count(20_000)), ..EXACT };
    // A lamp within the puff, one beside and one behind it.
    let lamps = [DVec3::new(0.4, 0.3, -5.2), DVec3::new(-1.0, 2.5, -4.0), DVec3::new(1.0, -1.0, -9.0)];
    let by_lamp = |position| puff_by(LightKind::Point, position, Rgb::new(60.0, 40.0, 20.0));
    let by_lamps = lamps.map(by_lamp);
    // And in other fog about it, which it shadows.
    let [mut about, mut behind] = [lamps[1], lamps[2]].map(by_lamp);
    let (low, high) = (DVec3::new(-3.0, -3.0, -11.0), DVec3::new(3.0, 3.0, -1.0));
    for scene in [&mut about, &mut behind] {
        add_fog(scene, low, high, Rgb::splat(0.05), Rgb::splat(0.9), 0.3);
    }
    let mut under_sun = lit_puff();
    add_fog(&mut under_sun, low, high, Rgb::new(0.05, 0.06, 0.08), Rgb::splat(0.9), 0.3);
    for scene in [lit_puff(), under_sun, about, behind].iter().chain(&by_lamps) {
        for place in [[0.5, 0.5], [0.42, 0.55], [0.53, 0.46]] {
            let (expected, found) = (seen(scene, &march, place, 0), seen(scene, &EXACT, place, 0));
            assert!(found.radiance.min_element() > 0.005, "{place:?}: {}", found.radiance);
            let off = (found.radiance / expected.radiance - 1.0).abs().max_element();
            assert!(off < 2e-3, "{:?}, {place:?}: {} {}", scene.lights, found.radiance, expected.radiance);
        }
    }
}

/// Voxels so wide and thick that light ends within one of them, and thicker ones, too many for a lattice.
#[test]
fn a_march_finds_the_light_of_thick_voxels() {
    let march = Transport { volume: VolumeMethod::March(MarchSteps::Count(20_000)), ..EXACT };
    let wide =
        DAffine3::from_translation(DVec3::new(-1.5, -1.5, -6.5)) * DAffine3::from_scale(DVec3::splat(1.5));
    let mut few = VoxelsBuilder::default();
    let value = |place: usize| if place & 7 < 2 && place >> 3 & 7 < 3 && place >> 6 < 2 { 1.0 } else { 0.0 };
    few.add(IVec3::ZERO, (0..512).map(|place| value(place) * (1 + place * 7 % 5) as f32 / 5.0));
    let few = few.built().expect("it holds something");
    for (world_from_voxel, voxels, density_per_m) in [(wide, few, 8.0), (turned(), puff(), 200.0)] {
        let mut scene = camera_at(DVec3::ZERO);
        add_voxels(&mut scene, world_from_voxel, voxels, Rgb::splat(density_per_m));
        let beam = DVec3::new(0.5, -0.7, -0.3);
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, beam, Rgb::new(30.0, 20.0, 10.0));
        for place in [[0.5, 0.5], [0.42, 0.55], [0.53, 0.46]] {
            let (expected, found) = (seen(&scene, &march, place, 0), seen(&scene, &EXACT, place, 0));
            assert!(found.radiance.min_element() > 0.005, "{place:?}: {}", found.radiance);
            let off = (found.radiance / expected.radiance - 1.0).abs().max_element();
            // A hundredth is what optical depths to the sun may err by.
            assert!(off < 1.5e-2, "{density_per_m}, {place:?}: {} {}", found.radiance, expected.radiance);
        }
    }
}

/// And random walks, which invert depths.
#[test]
fn walks_find_the_same_light() {
    let scene = lit_puff();
    let walks = Transport { volume: VolumeMethod::Paths(Bounces::NONE), ..EXACT };
    let place = [0.5, 0.5];
    let found = seen(&scene, &EXACT, place, 0).radiance;
    let count = 20_000;
    let (mut sum, mut squares) = (Rgb::ZERO, Rgb::ZERO);
    for seed in 0..count {
        let one = seen(&scene, &walks, place, seed).radiance;
        sum += one / f64::from(count);
        squares += one * one / f64::from(count);
    }
    let error = ((squares - sum * sum) / f64::from(count)).map(|variance| variance.max(0.0).sqrt());
    let off = (found - sum).abs() - 4.0 * error;
    assert!(off.max_element() < 1e-3 * found.max_element(), "{found} {sum} +- {error}");
}

/// What is found once for all rays of a camera is what each of them finds, within the lattice's tolerance: of
/// a small picture, of one whose rays would be too many, and of fog that ends where it is densest. Where that
/// fog is thick and the picture smallest, no lattice is fine enough, and each ray goes alone.
#[test]
fn fog_that_the_camera_sees_is_that_of_its_rays() {
    let lit_block = |density_per_m: Rgb| {
        let mut block = VoxelsBuilder::default();
        block.add_even(IVec3::ZERO, 24, 1.0).expect("it is small");
        let mut scene = camera_at(DVec3::ZERO);
        add_voxels(&mut scene, turned(), block.built().expect("fog"), density_per_m);
        let beam = DVec3::new(0.5, -0.7, -0.3);
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, beam, Rgb::new(3.0, 2.0, 1.0));
        scene
    };
    let (soft, hard) = (lit_puff(), lit_block(Rgb::new(0.01, 0.012, 0.015)));
    let thick = lit_block(Rgb::splat(0.6));
    for (scene, side) in [(&soft, 160), (&soft, 1600), (&hard, 640), (&thick, 40)] {
        let trees = MeshTrees::new(scene);
        let alone = Snapshot::new(scene, &trees, 0, 1.0, INSTANT);
        let exposure = Exposure::new(scene, &trees, 0, 1.0, INSTANT);
        exposure.see_fog(Size { width: side, height: side });
        let known = exposure.middle();
        assert!(alone.seen_fog().is_none());
        assert_eq!(known.seen_fog().is_some(), side > 40);
        let (mut sum, mut all, mut difference, mut squares) = (Rgb::ZERO, Rgb::ZERO, Rgb::ZERO, Rgb::ZERO);
        for number in 0..1500 {
            let [x, y] = Sampler::new(number, 0, 0, 0).next_2d().into();
            let ray = alone.view.ray(x, y);
            let [expected, found] = [&alone, known].map(|snapshot| {
                let (mut sampler, mut scratch) = (Sampler::new(number, 0, 0, 0), Scratch::default());
                radiance(snapshot, &EXACT, &ray, &mut sampler, &mut scratch)
            });
            let off = (found.transmittance - expected.transmittance).abs().max_element();
            assert!(off < 0.02, "{side}, {x} {y}: {off}");
            let off = found.radiance - expected.radiance;
            (sum, all) = (sum + expected.radiance, all + expected.radiance * expected.radiance);
            (difference, squares) = (difference + off, squares + off * off);
        }
        // As the lattice counts it: by the root mean square of the light.
        let error = (squares / all).map(f64::sqrt);
        println!("{side}: {difference} of {sum}, root mean square {error}");
        assert!((difference / sum).abs().max_element() < 2e-3, "{side}: {difference} {sum}");
        assert!(error.max_element() < 0.02, "{side}: {error}");
    }
}

fn refusal(fog: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.ron");
    let vdb = checkout::file("tests/data/vdb");
    for name in ["several.vdb", "billion.vdb"] {
        std::fs::copy(vdb.join(name), folder.path().join(name)).expect("a file");
    }
    std::fs::write(folder.path().join("none.vdb"), b"no grid").expect("a file");
    let scene = format!(r#"Scene(version: 1, cameras: {{ "main": () }}, fog: {{ "mist": ({fog}) }})"#);
    std::fs::write(&path, scene).expect("a file");
    match description::load(&path) {
        Ok(description) => scene::resolve(description, None).expect_err("it is no fog").to_string(),
        Err(error) => error.diagnostics().to_string(),
    }
}

/// What is refused names the place, what was expected and what helps.
#[test]
fn what_is_no_fog_is_refused() {
    for (fog, found) in [
        (r#"vdb: "nowhere.vdb", density_per_m: 1.0"#, "nowhere.vdb"),
        (r#"vdb: "none.vdb", density_per_m: 1.0"#, "none.vdb"),
        (r#"vdb: "several.vdb", grid: "smoke", density_per_m: 1.0"#, "there is no grid `smoke`"),
        (r#"vdb: "several.vdb", grid: "velocity", density_per_m: 1.0"#, "grid `velocity` is a "),
        (r#"vdb: "several.vdb", grid: "nothing", density_per_m: 1.0"#, "grid `nothing`: no voxel is above 0"),
        (r#"vdb: "several.vdb", min_m: (0.0, 0.0, 0.0), density_per_m: 1.0"#, "`min_m` stands beside `vdb`"),
        (r#"vdb: "several.vdb", scale_height_m: 1.0, density_per_m: 1.0"#, "`scale_height_m` stands beside"),
        (r#"grid: "density", density_per_m: 1.0"#, "`grid` names one of a file that is not named"),
    ] {
        let said = refusal(fog);
        assert!(said.contains(found), "{fog}: {said}");
        assert!(said.contains("remedy"), "{fog}: {said}");
    }
}
