//! Tests of films as a whole.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::color::Rgb;
use crate::transport::{Matte, SurfaceFeatures};
use glam::DVec3;
use proptest::prelude::*;

const ALL: [Pass; 9] = [
    Pass::Shafts,
    Pass::Transmittance,
    Pass::Depth,
    Pass::Normal,
    Pass::Position,
    Pass::Albedo,
    Pass::LeafId,
    Pass::Motion,
    Pass::Cryptomatte,
];
const SIZE: Size = Size { width: 4, height: 3 };

fn whole() -> Window {
    Window::whole(SIZE)
}

fn leaf(radiance: f64, depth_m: f64, leaf_id: u32) -> Sample {
    Sample {
        radiance: Rgb::splat(radiance),
        emitted: Rgb::ZERO,
        hue: Rgb::ONE,
        indirect: Rgb::ZERO,
        indirect_shafts: Rgb::ZERO,
        shafts: Rgb::splat(0.25 * radiance),
        transmittance: Rgb::splat(0.5),
        alpha: 1.0,
        surface: Some(SurfaceFeatures {
            depth_m,
            normal: DVec3::Y,
            position: DVec3::new(1.0, 2.0, depth_m),
            albedo: Rgb::splat(0.5),
            leaf_id,
        }),
        motion_px: [depth_m, 0.0, -depth_m, 1.0],
        mattes: [Matte { id: leaf_id, share: 1.0 }, Matte::default(), Matte::default(), Matte::default()],
    }
}

fn pixel(frame: &Frame, channel: &str, x: usize, y: usize) -> f32 {
    frame.channel(channel).unwrap().pixels[frame.window.index(x, y).unwrap()]
}

#[test]
fn weights_need_not_sum_to_anything() {
    let mut film = Film::new(SIZE, whole(), &[Pass::Shafts]);
    film.add(&Splat { pixel: (1, 1), weight: 0.03, from_centre_px: 0.0 }, &leaf(1.0, 1.0, 1));
    film.add(&Splat { pixel: (1, 1), weight: 0.01, from_centre_px: 0.0 }, &leaf(5.0, 1.0, 1));
    let frame = film.resolve();
    assert_eq!(pixel(&frame, "R", 1, 1), 2.0);
    assert_eq!(pixel(&frame, "shafts.B", 1, 1), 0.5);
    assert_eq!(pixel(&frame, "A", 1, 1), 1.0);
}

#[test]
fn data_passes_show_the_sample_nearest_to_the_centre_and_the_first_of_equals() {
    let mut film = Film::new(SIZE, whole(), &ALL);
    film.add(&Splat { pixel: (2, 0), weight: 1.0, from_centre_px: 0.4 }, &leaf(1.0, 7.0, 7));
    film.add(&Splat { pixel: (2, 0), weight: 1.0, from_centre_px: 0.1 }, &leaf(1.0, 8.0, 8));
    film.add(&Splat { pixel: (2, 0), weight: 1.0, from_centre_px: 0.1 }, &leaf(1.0, 9.0, 9));
    film.add(&Splat { pixel: (2, 0), weight: 1.0, from_centre_px: 0.3 }, &Sample::default());
    let frame = film.resolve();
    assert_eq!(pixel(&frame, "Z", 2, 0), 8.0);
    assert_eq!(pixel(&frame, "Position.Z", 2, 0), 8.0);
    assert_eq!(pixel(&frame, "leaf_id.X", 2, 0), 8.0);
    assert_eq!(
        ["X", "Y", "Z", "W"].map(|name| pixel(&frame, &format!("Vector.{name}"), 2, 0)),
        [8.0, 0.0, -8.0, 1.0]
    );
    assert_eq!(pixel(&frame, "Normal.Y", 2, 0), 0.75, "averaged, the background counts as 0");
}

/// Eight objects, some seen more than once: the six that cover most, ids as bits.
#[test]
fn mattes_are_ranked_by_coverage() {
    let mut film = Film::new(SIZE, whole(), &[Pass::Cryptomatte]);
    for (id, times) in [(1, 1), (2, 5), (3, 2), (4, 2), (5, 3), (6, 1), (7, 4), (8, 1)] {
        for _ in 0..times {
            film.add(&Splat { pixel: (1, 2), weight: 0.5, from_centre_px: 0.0 }, &leaf(1.0, 1.0, id));
        }
    }
    let half = Matte { id: 2, share: 0.5 };
    film.add(
        &Splat { pixel: (1, 2), weight: 0.5, from_centre_px: 0.0 },
        &Sample { mattes: [half; 4], ..Sample::default() },
    );
    let frame = film.resolve();
    let ranks = (0..3).flat_map(|layer| [("R", "G"), ("B", "A")].map(|pair| (layer, pair)));
    let found: Vec<(u32, f32)> = ranks
        .map(|(layer, (id, coverage))| {
            let at = |letter: &str| pixel(&frame, &format!("CryptoObject{layer:02}.{letter}"), 1, 2);
            (at(id).to_bits(), at(coverage))
        })
        .collect();
    let coverage = |times: f64| (times / 20.0) as f32;
    let expected = [(2, 7.0), (7, 4.0), (5, 3.0), (3, 2.0), (4, 2.0), (1, 1.0)];
    assert_eq!(found, expected.map(|(id, times)| (id, coverage(times))));
    assert_eq!(pixel(&frame, "CryptoObject00.G", 1, 1), found[0].1, "a hole takes over from its neighbour");
}

#[test]
fn background_has_the_depth_that_blender_writes() {
    let mut film = Film::new(SIZE, whole(), &ALL);
    film.add(&Splat { pixel: (0, 0), weight: 1.0, from_centre_px: 0.0 }, &Sample::default());
    let frame = film.resolve();
    assert_eq!(pixel(&frame, "Z", 0, 0), 1e10);
    assert_eq!(pixel(&frame, "leaf_id.X", 0, 0), 0.0);
    assert_eq!(pixel(&frame, "A", 0, 0), 0.0);
}

#[test]
fn only_the_passes_asked_for_have_channels() {
    let names = |passes: &[Pass]| -> Vec<String> {
        Film::new(SIZE, whole(), passes).resolve().channels.into_iter().map(|channel| channel.name).collect()
    };
    assert_eq!(names(&[]), ["R", "G", "B", "A"]);
    assert_eq!(names(&[Pass::LeafId, Pass::Depth, Pass::Depth]), ["R", "G", "B", "A", "Z", "leaf_id.X"]);
    assert!(Film::new(SIZE, whole(), &[Pass::Shafts]).nearest_distances_px.is_empty());
}

#[test]
fn a_nan_sample_stays_nan() {
    let mut film = Film::new(SIZE, whole(), &[]);
    for (x, y) in whole().pixels() {
        film.add(&Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 }, &leaf(1.0, 1.0, 1));
    }
    film.add(&Splat { pixel: (3, 2), weight: 1.0, from_centre_px: 0.0 }, &leaf(f64::NAN, 1.0, 1));
    let defects = film.resolve().check();
    assert_eq!(defects.nan.count, 3);
    let first = defects.nan.first.unwrap();
    assert_eq!((first.channel.as_str(), first.x, first.y), ("R", 3, 2));
}

#[test]
fn samples_outside_a_cropped_window_are_left_to_others() {
    let window = Window { x: 2, y: 1, width: 2, height: 2 };
    let mut film = Film::new(SIZE, window, &[]);
    film.add(&Splat { pixel: (1, 1), weight: 1.0, from_centre_px: 0.0 }, &leaf(9.0, 1.0, 1));
    film.add(&Splat { pixel: (2, 1), weight: 1.0, from_centre_px: 0.0 }, &leaf(1.0, 1.0, 1));
    assert_eq!(film.holes().len(), 3);
    assert_eq!(pixel(&film.resolve(), "R", 2, 1), 1.0);
}

proptest! {
    /// Tiles that do not overlap give the same bits in any order of pasting, and the same as no tiles.
    #[test]
    fn tiles_in_any_order_equal_one_film(
        samples in prop::collection::vec((0_usize..4, 0_usize..3, 0.0..2.0_f64, 0.0..0.7_f64, 0.0..9.0_f64), 0..60),
        split in 1_usize..4,
    ) {
        let left = Window { x: 0, y: 0, width: split, height: 3 };
        let right = Window { x: split, y: 0, width: 4 - split, height: 3 };
        let mut parts = [left, right].map(|window| Film::new(SIZE, window, &ALL));
        let mut one = Film::new(SIZE, whole(), &ALL);
        for (id, &(x, y, weight, distance, radiance)) in samples.iter().enumerate() {
            let sample = leaf(radiance, radiance + 1.0, id as u32 + 1);
            one.add(&Splat { pixel: (x, y), weight, from_centre_px: distance }, &sample);
            parts.iter_mut().for_each(|part| part.add(&Splat { pixel: (x, y), weight, from_centre_px: distance }, &sample));
        }
        for order in [[0, 1], [1, 0]] {
            let mut pasted = Film::new(SIZE, whole(), &ALL);
            order.iter().for_each(|&part| pasted.paste(&parts[part]));
            prop_assert_eq!(pasted.resolve(), one.resolve());
        }
    }
}
