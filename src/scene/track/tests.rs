//! Tests of tracks through keys of every kind.
#![allow(clippy::unwrap_used)]

use super::*;
use glam::{DQuat, DVec3};
use proptest::prelude::*;

fn key<T>(time_s: f64, value: T, to_next: Segment<T>) -> Key<T> {
    Key { time_s, value, to_next }
}

fn track<T: Animate>(keys: Vec<Key<T>>) -> Track<T> {
    Track::new(keys, Extend::Hold).unwrap()
}

fn segment() -> impl Strategy<Value = Segment<f64>> {
    let handle = (-3.0..3.0, -2.0..2.0).prop_map(|(time_s, value)| Handle { time_s, value });
    prop_oneof![
        Just(Segment::Step),
        Just(Segment::Linear),
        (-5.0..5.0, -5.0..5.0).prop_map(|(leave, arrive)| Segment::Hermite { leave, arrive }),
        (handle.clone(), handle).prop_map(|(leave, arrive)| Segment::Bezier { leave, arrive }),
    ]
}

proptest! {
    #[test]
    fn passes_through_its_keys(values in prop::collection::vec((-1e3..1e3_f64, segment()), 1..8)) {
        let keys: Vec<_> =
            values.iter().enumerate().map(|(i, (v, s))| key(i as f64 * 0.7, *v, *s)).collect();
        let track = track(keys.clone());
        prop_assert_eq!(&track.keys(), &keys);
        for key in keys {
            prop_assert!((track.at(key.time_s) - key.value).abs() <= 1e-12 * key.value.abs());
        }
    }

    #[test]
    fn hermite_reproduces_any_cubic(c in prop::array::uniform4(-3.0..3.0_f64), u in 0.0..1.0_f64) {
        let value = |t: f64| c[0] + t * (c[1] + t * (c[2] + t * c[3]));
        let slope = |t: f64| c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]);
        let (start_s, end_s) = (1.25, 4.0);
        let curve = track(vec![
            key(start_s, value(start_s), Segment::Hermite { leave: slope(start_s), arrive: slope(end_s) }),
            key(end_s, value(end_s), Segment::Step),
        ]);
        let time_s = start_s + u * (end_s - start_s);
        prop_assert!((curve.at(time_s) - value(time_s)).abs() < 1e-11);
    }

    #[test]
    fn bezier_finds_every_point_of_its_parametric_curve(
        x1 in 0.0..1.0_f64, x2 in 0.0..1.0_f64, y in prop::array::uniform4(-3.0..3.0_f64), s in 0.0..1.0_f64
    ) {
        let curve = track(vec![
            key(0.0, y[0], Segment::Bezier {
                leave: Handle { time_s: x1, value: y[1] },
                arrive: Handle { time_s: x2, value: y[2] },
            }),
            key(1.0, y[3], Segment::Step),
        ]);
        // De Casteljau, as an oracle that shares nothing with the evaluation.
        let point = |mut p: [f64; 4]| {
            for level in (1..4).rev() {
                for i in 0..level {
                    p[i] = p[i] * (1.0 - s) + p[i + 1] * s;
                }
            }
            p[0]
        };
        let slope = 3.0 * ((1.0 - s) * (1.0 - s) * x1 + 2.0 * s * (1.0 - s) * (x2 - x1) + s * s * (1.0 - x2));
        prop_assume!(slope > 1e-3);
        prop_assert!((curve.at(point([0.0, x1, x2, 1.0])) - point(y)).abs() < 1e-9);
    }

    #[test]
    fn bezier_time_never_runs_backwards(handles in prop::array::uniform4(-5.0..5.0_f64)) {
        // With values equal to times the curve is the identity wherever time is single-valued.
        let curve = track(vec![
            key(0.0, 0.0, Segment::Bezier {
                leave: Handle { time_s: handles[0].max(0.0), value: handles[0].max(0.0) },
                arrive: Handle { time_s: handles[1].min(1.0), value: handles[1].min(1.0) },
            }),
            key(1.0, 1.0, Segment::Step),
        ]);
        for step in 0..=50 {
            let time_s = f64::from(step) / 50.0;
            prop_assert!((curve.at(time_s) - time_s).abs() < 1e-9);
        }
    }

    #[test]
    fn cycles_repeat_and_holds_hold(time_s in -50.0..50.0_f64) {
        let keys = vec![key(1.0, 0.0, Segment::Linear), key(2.0, 1.0, Segment::Linear), key(4.0, 5.0, Segment::Step)];
        let cycle = Track::new(keys.clone(), Extend::Cycle).unwrap();
        let hold = track(keys);
        let phase_s = 1.0 + (time_s - 1.0).rem_euclid(3.0);
        prop_assume!(phase_s < 3.999);
        prop_assert!((cycle.at(time_s) - hold.at(phase_s)).abs() < 1e-9);
        prop_assert_eq!(hold.at(1.0 - time_s.abs()), 0.0);
        prop_assert_eq!(hold.at(4.0 + time_s.abs()), 5.0);
    }
}

#[test]
fn cycle_starts_over_at_its_last_key() {
    let keys = vec![key(0.0, 0.0, Segment::Linear), key(0.1, 1.0, Segment::Step)];
    let cycle = Track::new(keys, Extend::Cycle).unwrap();
    for round in -30..30 {
        assert!(cycle.at(f64::from(round) * 0.1).abs() < 1e-9, "round {round}");
    }
}

#[test]
fn step_keys_stored_in_single_precision_are_found_on_their_frame() {
    let keys = (0..48)
        .map(|frame| key(f64::from((f64::from(frame) / 24.0) as f32), f64::from(frame), Segment::Step))
        .collect();
    let track = track(keys);
    for frame in 0..48 {
        assert_eq!(track.at(f64::from(frame) / 24.0), f64::from(frame));
    }
}

#[test]
fn bezier_matches_blender() {
    // Keys 0 at frame 1 and 1 at frame 48 with Blender's automatic handles, which lie flat at a
    // third; values as Blender 5.0.1 evaluates them.
    let curve = track(vec![
        key(
            1.0,
            0.0,
            Segment::Bezier {
                leave: Handle { time_s: 1.0 + 47.0 / 3.0, value: 0.0 },
                arrive: Handle { time_s: 48.0 - 47.0 / 3.0, value: 1.0 },
            },
        ),
        key(48.0, 1.0, Segment::Step),
    ]);
    for (frame, value) in
        [(1.0, 0.0), (6.0, 0.031544), (12.5, 0.150309), (13.0, 0.162276), (24.0, 0.484045), (36.25, 0.84375)]
    {
        assert!((curve.at(frame) - value).abs() < 1e-6, "frame {frame}");
    }
}

#[test]
fn quaternion_spline_stays_on_the_unit_sphere() {
    let half_turn = DQuat::from_rotation_y(std::f64::consts::PI);
    let hermite = Segment::Hermite { leave: DQuat::ZERO, arrive: DQuat::ZERO };
    let track = track(vec![key(0.0, DQuat::IDENTITY, hermite), key(1.0, half_turn, Segment::Step)]);
    for step in 0..=10 {
        assert!((track.at(f64::from(step) / 10.0).length() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn constant_means_the_same_value_at_all_times() {
    let two = |to_next| track(vec![key(0.0, 2.0, to_next), key(1.0, 2.0, Segment::Step)]);
    let flat = Handle { time_s: 0.5, value: 2.0 };
    assert!(Track::from(2.0).is_constant());
    assert!(two(Segment::Linear).is_constant());
    assert!(two(Segment::Hermite { leave: 0.0, arrive: 0.0 }).is_constant());
    assert!(!two(Segment::Hermite { leave: 1.0, arrive: 0.0 }).is_constant());
    assert!(two(Segment::Bezier { leave: flat, arrive: flat }).is_constant());
    let bump = Handle { value: 3.0, ..flat };
    assert!(!two(Segment::Bezier { leave: flat, arrive: bump }).is_constant());
    assert!(!track(vec![key(0.0, 2.0, Segment::Step), key(1.0, 3.0, Segment::Step)]).is_constant());
}

#[test]
fn visibility_switches_at_its_keys() {
    let track = track(vec![key(0.0, true, Segment::Step), key(1.0, false, Segment::Step)]);
    assert!(track.at(0.999) && !track.at(1.0));
}

#[test]
fn one_slope_a_key_is_kept_once_and_given_back() {
    let spline = |leave: f64, arrive: f64| Segment::Hermite { leave, arrive };
    let smooth = vec![
        key(0.0, 1.0, spline(0.5, -1.0)),
        key(1.0, 2.0, spline(-1.0, 3.0)),
        key(2.5, 0.0, spline(3.0, 0.0)),
    ];
    let mut kinked = smooth.clone();
    kinked[1].to_next = spline(-1.5, 3.0);
    assert!(
        matches!(track(smooth.clone()).0, Course::Keyed(keyed) if matches!(keyed.to_next, Ways::Smooth(_)))
    );
    assert!(
        matches!(track(kinked.clone()).0, Course::Keyed(keyed) if matches!(keyed.to_next, Ways::Each(_)))
    );
    for keys in [smooth, kinked] {
        let track = track(keys.clone());
        assert_eq!(track.keys(), keys);
        let doubled = track.map_linear(|value| 2.0 * value);
        assert!((0..50).all(|at| doubled.at(0.05 * f64::from(at)) == 2.0 * track.at(0.05 * f64::from(at))));
    }
}

#[test]
fn splines_of_short_numbers_are_kept_in_few_bytes_and_given_back() {
    let spline = |leave: DVec3, arrive: DVec3| Segment::Hermite { leave, arrive };
    let keys = |last: f64| {
        let (up, down) = (DVec3::new(0.5, 2.0, -0.25), DVec3::new(0.0, -4.0, last));
        vec![
            key(0.25, DVec3::X, spline(up, down)),
            key(1.0, down, spline(down, up)),
            key(2.5, up, spline(up, DVec3::ZERO)),
        ]
    };
    let (kept, lost) = (track(keys(0.5)), track(keys(0.1)));
    assert!(matches!(kept.0, Course::Smooth(_)) && matches!(lost.0, Course::Keyed(_)));
    for (track, keys) in [(&kept, keys(0.5)), (&lost, keys(0.1))] {
        assert_eq!(track.keys(), keys);
        assert_eq!((track.at(0.0), track.at(9.0)), (keys[0].value, keys[2].value));
        let doubled = track.map_linear(|value| 2.0 * value);
        assert!((0..50).all(|at| doubled.at(0.05 * f64::from(at)) == 2.0 * track.at(0.05 * f64::from(at))));
    }
    assert!(!kept.is_constant() && !lost.is_constant());
}

#[test]
fn shortened_curves_are_kept_in_few_bytes_written_and_joined() {
    let start_s = 100.0 / 3.0;
    let key = |time_s: f64| {
        let turn = DQuat::from_rotation_y(time_s);
        SmoothKey { time_s, value: turn, slope: turn * 0.3 }.shortened(start_s)
    };
    let keys = |times: std::ops::Range<u32>| -> Vec<_> {
        times.map(|time| key(start_s + 0.07 * f64::from(time))).collect()
    };
    let [all, first, second] = [0..9, 0..5, 4..9].map(|times| Track::smooth(start_s, &keys(times)).unwrap());
    assert!(matches!(all.0, Course::Smooth(_)));
    assert_eq!(first.then(second).unwrap().keys(), all.keys());
    for at in 0..=8 {
        let time_s = start_s + 0.07 * f64::from(at);
        assert!((all.at(time_s) - DQuat::from_rotation_y(time_s)).length() < 1e-4);
    }
    let mut bytes = Vec::new();
    all.write(&mut bytes).unwrap();
    assert_eq!(bytes.len(), 16 + 9 * 20);
    assert_eq!(Track::read(&mut &bytes[..]).unwrap(), all);
    assert!((0..bytes.len()).all(|length| Track::<DQuat>::read(&mut &bytes[..length]).is_none()));
    // Times that do not increase.
    bytes.copy_within(36..56, 16);
    assert!(Track::<DQuat>::read(&mut &bytes[..]).is_none());
}

#[test]
fn keys_out_of_order_make_no_track() {
    let keys = |times: &[f64]| times.iter().map(|&t| key(t, 0.0, Segment::Step)).collect();
    for times in [&[][..], &[1.0, 1.0], &[1.0, 0.0], &[f64::NAN], &[0.0, f64::INFINITY]] {
        assert!(Track::<f64>::new(keys(times), Extend::Hold).is_none(), "{times:?}");
    }
}

#[test]
fn keys_of_other_times_go_and_no_value_changes() {
    let turn = |angle: f64| DQuat::from_rotation_y(angle);
    let key = |time: i32| {
        // At rest from 30 s on.
        let time_s = f64::from(time.min(30));
        let slope = if time < 30 { turn(time_s) * 0.3 } else { DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0) };
        SmoothKey { time_s: f64::from(time), value: turn(time_s), slope }.shortened(-1.0)
    };
    let keys: Vec<SmoothKey<DQuat>> = (0..40).map(key).collect();
    let all = Track::smooth(-1.0, &keys).unwrap();
    for (from_s, to_s, most) in [(-9.0, -8.0, 4), (4.2, 6.0, 6), (7.0, 7.0, 5), (35.2, 36.0, 40)] {
        let mut kept = all.clone();
        kept.keep_span((from_s, to_s));
        assert!(kept.times_s().len() <= most, "{from_s} {}", kept.times_s().len());
        assert_eq!(kept.is_constant(), all.is_constant());
        for share in [0.0, 0.3, 0.7, 1.0] {
            let time_s = from_s + share * (to_s - from_s);
            assert_eq!(kept.at(time_s), all.at(time_s), "{time_s}");
        }
    }
}
