//! Tests of mist: its amount, place and time. Invariant: all places that are compared are those of voxels.

use super::*;
use crate::scene::Keyed;

fn mist(wind: DVec3, cover: f64) -> Mist {
    Mist {
        bounds: [DVec3::new(-8.0, 0.0, -8.0), DVec3::new(8.0, 8.0, 8.0)],
        shape: MistShape::Box,
        edge_m: 0.0,
        size_m: 2.0,
        octaves: 3,
        cover: cover.into(),
        wind: Drift::new(wind.into()),
        evolution_turns: 0.0.into(),
        base_m: 0.0,
        scale_height_m: None,
        ground: None,
        seed: 4,
        voxel_m: 0.25,
        kept: Recent::default(),
    }
}

fn at(mist: &Mist, time_s: f64, place: DVec3) -> f64 {
    mist.voxels(time_s).map_or(0.0, |voxels| voxels.voxels.at(place / mist.voxel_m))
}

/// Places of voxels well within the box.
fn places() -> impl Iterator<Item = DVec3> {
    let along = |index: i32| f64::from(index) * 0.5;
    (-12..12).flat_map(move |x| {
        (2..14).flat_map(move |y| (-12..12).map(move |z| DVec3::new(along(x), along(y), along(z))))
    })
}

#[test]
fn it_fills_as_much_as_it_is_told_to() {
    for cover in [0.2, 0.5, 0.8] {
        let mist = mist(DVec3::ZERO, cover);
        let full = places().filter(|place| at(&mist, 0.0, *place) > 0.0).count();
        let share = full as f64 / places().count() as f64;
        assert!((share - cover).abs() < 0.06, "{cover}: {share}");
    }
    assert!(mist(DVec3::ZERO, 0.0).voxels(0.0).is_none());
}

/// Whatever was asked before, and by another copy of it.
#[test]
fn it_is_a_function_of_time_alone() {
    let (first, second) = (mist(DVec3::X, 0.6), mist(DVec3::X, 0.6));
    let place = DVec3::new(1.0, 2.0, 3.0);
    for time_s in [0.0, 3.0, 1.0, 0.0] {
        at(&first, time_s, place);
    }
    for place in places().step_by(17) {
        assert_eq!(at(&first, 1.5, place), at(&second, 1.5, place));
    }
    assert!(!first.is_constant() && mist(DVec3::ZERO, 0.6).is_constant());
}

#[test]
fn wind_carries_it() {
    let mist = mist(DVec3::new(0.5, 0.0, -0.25), 0.6);
    for place in places().step_by(17) {
        let (before, behind) = (at(&mist, 1.0, place), at(&mist, 3.0, place + DVec3::new(1.0, 0.0, -0.5)));
        assert!((before - behind).abs() < 1e-5, "{place}: {before} {behind}");
    }
}

#[test]
fn it_fades_towards_its_edge_and_ends_there() {
    let mist = Mist { edge_m: 2.0, shape: MistShape::Ellipsoid, ..mist(DVec3::ZERO, 1.0) };
    assert!(at(&mist, 0.0, DVec3::new(0.0, 4.0, 0.0)) > 0.9);
    assert!(at(&mist, 0.0, DVec3::new(7.0, 4.0, 0.0)) < 0.5);
    for corner in mist.bounds {
        assert_eq!(at(&mist, 0.0, corner), 0.0);
    }
    let (low, high) = mist.voxels(0.0).expect("there is mist").voxels.bounds();
    let slack = DVec3::splat(mist.voxel_m);
    let is_in = (low * mist.voxel_m).cmpge(mist.bounds[0] - slack).all()
        && (high * mist.voxel_m).cmple(mist.bounds[1] + slack).all();
    assert!(is_in, "{low} {high}");
}

/// A slope of one in two: as high over it there is as much, in it nothing.
#[test]
fn its_heights_count_from_the_ground() {
    let corner = |x: f64, z: f64| DVec3::new(x, 4.0 + 0.5 * x, z);
    let ground = [
        [corner(-8.0, -8.0), corner(8.0, -8.0), corner(8.0, 8.0)],
        [corner(-8.0, -8.0), corner(8.0, 8.0), corner(-8.0, 8.0)],
    ];
    let plain = mist(DVec3::ZERO, 1.0);
    let heights = GroundHeights::new(plain.bounds, plain.voxel_m, &ground);
    let mist = Mist { scale_height_m: Some(1.0.into()), ground: Some(Arc::new(heights)), ..plain };
    for (x, height_m) in [(-4.0, 0.5), (0.0, 0.5), (2.0, 1.0), (-4.0, 1.0)] {
        let found = at(&mist, 0.0, corner(x, 1.0) + height_m * DVec3::Y);
        // Noise so far below its threshold is rare.
        assert!((found / (-height_m).exp() - 1.0).abs() < 0.01, "{x} {height_m}: {found}");
    }
    assert_eq!(at(&mist, 0.0, corner(2.0, 1.0) - 2.0 * DVec3::Y), 0.0);
}
