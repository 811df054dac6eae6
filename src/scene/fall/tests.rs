//! Tests of falls of many leaves, for any leaf.

use super::leaf::Flight;
use super::*;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Frames of ten seconds.
const FRAMES: u32 = 240;

fn leaf_shape() -> Outline {
    // A diamond with a bent tip, 1 m long.
    let points = [(0.0, 0.0, 0.5), (-0.3, 0.05, 0.1), (0.3, 0.05, 0.1), (0.0, 0.1, 0.0), (0.0, -0.05, -0.5)];
    Outline::new(&points.map(|(x, y, z)| DVec3::new(x, y, z)), &TRIANGLES).unwrap()
}

const TRIANGLES: [[u32; 3]; 4] = [[0, 3, 1], [0, 2, 3], [1, 3, 4], [3, 2, 4]];

pub(super) fn calm() -> Wind {
    Wind::new(
        DVec3::ZERO,
        Gusts { speed_m_per_s: DVec3::ZERO, every_s: 1.0 },
        Eddies { speed_m_per_s: 0.0, size_m: 1.0 },
        0,
    )
}

pub(super) fn storm() -> Wind {
    Wind::new(
        DVec3::new(2.0, 0.0, 1.0),
        Gusts { speed_m_per_s: DVec3::new(3.0, 0.3, 0.0), every_s: 3.0 },
        Eddies { speed_m_per_s: 1.0, size_m: 2.0 },
        5,
    )
}

pub(super) fn every_way() -> FallMotion {
    let [steady, flutter, tumble, chaotic, helical, spiral] = [1.0.into(); 6];
    FallMotion { steady, flutter, tumble, chaotic, helical, spiral }
}

pub(super) fn fall(motion: FallMotion, wind: Wind, ground: Ground) -> Fall {
    let species = Species {
        share: 1.0,
        outlines: vec![leaf_shape()],
        length_m: (0.06, 0.12),
        width_m: None,
        areal_mass_kg_per_m2: (0.06, 0.1),
        curl: (0.0, 0.5),
    };
    Fall {
        count: 200,
        seed: 3,
        species: vec![species],
        motion: Some(motion),
        emitter: Emitter::Box(DVec3::new(-3.0, 2.0, -3.0), DVec3::new(3.0, 4.0, 3.0)),
        wind,
        ground,
        obstacles: Obstacles::default(),
        release_s: (0.0, 3.0),
        speed_gain: 1.0.into(),
    }
}

pub(super) fn level() -> Ground {
    Ground::new(0.25, Vec::new(), Vec::new())
}

/// Slopes and hills of 20 m, in squares of half a metre.
fn hills() -> Ground {
    let point = |i: i32, j: i32| {
        let (x, z) = (0.5 * f64::from(i), 0.5 * f64::from(j));
        DVec3::new(x, 0.3 * x.sin() * z.cos() + 0.1 * x, z)
    };
    let squares = (-40..40).flat_map(|i| (-40..40).map(move |j| (i, j)));
    let triangles = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    Ground::new(-9.0, triangles.collect(), Vec::new())
}

/// All leaves of a fall, which has its ground for itself.
fn bake(fall: &Fall) -> Vec<Fallen> {
    at_rest(&[fall], &Baking::ALONE).remove(0)
}

/// Points of the leaf's outline in the world.
fn points(leaf: &Fallen, time_s: f64) -> impl Iterator<Item = DVec3> {
    static SHAPE: LazyLock<Outline> = LazyLock::new(leaf_shape);
    let (turn, place) = (leaf.rotation.at(time_s), leaf.translation.at(time_s));
    let scale = leaf.scale;
    SHAPE.points.iter().map(move |&point| place + turn * ((point + SHAPE.middle) * scale))
}

/// Whether no other of the leaves lies so near that it could lie on it.
fn lies_apart(leaf: &Fallen, leaves: &[Fallen]) -> bool {
    let flat = |leaf: &Fallen| leaf.translation.at(1e4) * DVec3::new(1.0, 0.0, 1.0);
    leaves.iter().all(|other| std::ptr::eq(leaf, other) || flat(leaf).distance(flat(other)) > 0.13)
}

#[test]
fn no_leaf_goes_below_the_ground_and_each_comes_to_rest_on_it() {
    for (wind, ground) in [(calm(), level()), (storm(), level()), (calm(), hills()), (storm(), hills())] {
        let leaves = bake(&fall(every_way(), wind, ground.clone()));
        for leaf in &leaves {
            let height_m = |time_s: f64| {
                let above = points(leaf, time_s).map(|point| point.y - ground.height_m(point.x, point.z));
                above.fold(f64::INFINITY, f64::min)
            };
            // Four moments a frame, for motion blur.
            for moment in 0..4 * FRAMES {
                let time_s = f64::from(moment) / 96.0;
                assert!(height_m(time_s) > 0.0, "{} m at {time_s} s", height_m(time_s));
            }
            assert!(leaf.landed);
            let rest_m = height_m(1e4);
            let on_bare_ground = lies_apart(leaf, &leaves);
            assert!(!on_bare_ground || rest_m <= 2.0 * CLEARANCE * leaf.scale + 1e-9, "{rest_m}");
        }
    }
}

/// A trunk: a prism about the vertical through (1, 0) with a radius of 0.4 m.
fn trunk() -> Obstacles {
    let corner = |at: u32, y: f64| {
        let (sin, cos) = (TAU * f64::from(at) / 24.0).sin_cos();
        DVec3::new(1.0 + 0.4 * cos, y, 0.4 * sin)
    };
    let sides = (0..24).flat_map(|at| {
        let [a, b, c, d] = [corner(at, -1.0), corner(at + 1, -1.0), corner(at + 1, 9.0), corner(at, 9.0)];
        [[a, b, c], [a, c, d]]
    });
    Obstacles::new(&sides.collect::<Vec<_>>())
}

#[test]
fn no_leaf_goes_into_a_trunk() {
    // Blown against it from all over the box.
    let wind = Wind::new(
        DVec3::new(1.5, 0.0, 0.0),
        Gusts { speed_m_per_s: DVec3::new(3.0, 0.0, 0.0), every_s: 3.0 },
        Eddies { speed_m_per_s: 0.5, size_m: 2.0 },
        5,
    );
    let mut stopped = 0;
    let open = fall(every_way(), wind, level());
    let wooded = Fall { obstacles: trunk(), ..open.clone() };
    for (leaf, free) in bake(&wooded).iter().zip(&bake(&open)) {
        let hung_in_it =
            DVec3::new(1.0, 0.0, 0.0).distance(leaf.translation.at(-9.0) * DVec3::new(1.0, 0.0, 1.0)) < 0.55;
        if hung_in_it {
            continue;
        }
        stopped += u32::from(leaf != free);
        for moment in 0..4 * FRAMES {
            for point in points(leaf, f64::from(moment) / 96.0) {
                let off = f64::hypot(point.x - 1.0, point.z);
                // The prism's flat sides, and what curves may pass from poses.
                assert!(off > 0.4 * (PI / 24.0).cos() - TOLERANCE * leaf.scale, "{off}");
            }
        }
        assert!(leaf.landed);
    }
    assert!(stopped > 10, "{stopped}");
}

#[test]
fn leaves_lie_on_three_of_their_points() {
    let leaves = bake(&fall(every_way(), storm(), level()));
    for leaf in leaves.iter().filter(|leaf| lies_apart(leaf, &leaves)) {
        let heights: Vec<f64> = points(leaf, 1e4).map(|point| point.y).collect();
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let touching = heights.iter().filter(|&&height| height < lowest + 1e-3 * leaf.scale).count();
        assert!(touching >= 3, "{heights:?}");
    }
}

#[test]
fn leaves_neither_jump_nor_flip() {
    let rate = 480.0;
    // The fastest that these plates dive edgewise, and the wind. A leaf let go in a gust is turned by the
    // air that passes it: 5 m/s over half a chord of 3 cm.
    for (wind, fastest_m_per_s, fastest_rad_per_s) in [(calm(), 4.0, 90.0), (storm(), 10.0, 150.0)] {
        for leaf in bake(&fall(every_way(), wind, level())) {
            for moment in 0..(10.0 * rate) as u32 {
                let (now_s, next_s) = (f64::from(moment) / rate, f64::from(moment + 1) / rate);
                let moved = leaf.translation.at(next_s) - leaf.translation.at(now_s);
                let speed = moved.length() * rate;
                assert!(speed < fastest_m_per_s, "{speed} m/s at {now_s} s");
                let (a, b) = (leaf.rotation.at(now_s), leaf.rotation.at(next_s));
                let turned = 2.0 * (a.dot(b).abs().min(1.0)).acos() * rate;
                assert!(turned < fastest_rad_per_s, "{turned} rad/s at {now_s} s");
            }
        }
    }
}

#[test]
fn leaves_hang_still_before_they_are_let_go_and_lie_still_after_they_fell() {
    for leaf in bake(&fall(every_way(), storm(), hills())) {
        let last_s = *leaf.translation.times_s().last().unwrap();
        assert!((0.0..3.0).contains(&leaf.release_s) && last_s > leaf.release_s);
        for (still_s, then_s) in [(leaf.release_s, -5.0), (last_s, last_s + 100.0)] {
            assert_eq!(leaf.translation.at(still_s), leaf.translation.at(then_s));
            assert!(leaf.rotation.at(still_s).abs_diff_eq(leaf.rotation.at(then_s), 1e-14));
        }
    }
}

#[test]
fn no_two_leaves_fall_in_step() {
    // All at once and in still air, where nothing but themselves keeps them apart.
    let leaves = bake(&Fall { release_s: (0.0, 0.0), count: 60, ..fall(every_way(), calm(), level()) });
    let sways: Vec<Vec<f64>> = (leaves.iter())
        .map(|leaf| {
            let tilts: Vec<f64> =
                (0..72).map(|at| (leaf.rotation.at(f64::from(at) / 24.0) * DVec3::Y).y).collect();
            let mean = tilts.iter().sum::<f64>() / 72.0;
            let tilts: Vec<f64> = tilts.iter().map(|tilt| tilt - mean).collect();
            let length = tilts.iter().map(|tilt| tilt * tilt).sum::<f64>().sqrt();
            tilts.iter().map(|tilt| tilt / length.max(1e-9)).collect()
        })
        .collect();
    let pairs = (0..sways.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    let alike: Vec<f64> =
        pairs.map(|(a, b)| sways[a].iter().zip(&sways[b]).map(|(x, y)| x * y).sum::<f64>()).collect();
    let mean = alike.iter().sum::<f64>() / alike.len() as f64;
    let in_step = alike.iter().filter(|&&alike| alike > 0.95).count();
    assert!(mean.abs() < 0.1 && in_step * 100 < alike.len(), "{mean} {in_step} of {}", alike.len());
    assert!(alike.iter().all(|&alike| alike < 0.999));
}

#[test]
fn threads_do_not_change_the_leaves() {
    let fall = fall(every_way(), storm(), hills());
    let on = |threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| bake(&fall))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn the_flight_is_the_one_of_this_edition() {
    // Bits, for chaos makes last ones seen. If these change on purpose, `kept::EDITION` rises with them.
    let golden = [
        [0x4026_2f9b_f898_fbbd, 0x4007_8960_ac11_4105, 0x3ff8_5b4a_b0e4_3e65, 0xbfe8_b916_1947_19c7_u64],
        [0x4022_84d5_935b_18f6, 0x4004_a46e_3925_7c17, 0x4010_2e71_e7f0_21a1, 0xbfe0_2218_782d_0d9f],
        [0x4025_fcc2_2daf_e571, 0x3ffc_eec2_7a6d_53d5, 0x4004_c19d_f221_d216, 0xbfed_dd1d_92ea_a956],
    ];
    let leaves = bake(&Fall { count: 3, ..fall(every_way(), storm(), hills()) });
    let found: Vec<[u64; 4]> = (leaves.iter())
        .map(|leaf| {
            let (place, turn) = (leaf.translation.at(5.0), leaf.rotation.at(5.0));
            [place.x, place.y, place.z, turn.w].map(f64::to_bits)
        })
        .collect();
    assert_eq!((kept::EDITION, &found[..]), (4, &golden[..]), "{found:#x?}");
}

#[test]
fn curves_go_through_all_poses() {
    // Within the tolerance, and in between no farther: of half as many keys as poses there is a curve left.
    for (inertia, damping) in [(0.8, 0.2), (1.4, 0.2), (2.0, 0.2), (0.3, 8.0)] {
        let interval_s = 0.4 * 0.047;
        let mut flight = lone_flight(inertia, damping, interval_s, &calm());
        // The last is at a time of its own.
        flight.poses.pop();
        keys::to_one_side(&mut flight.poses, DQuat::IDENTITY);
        let fine = lone_flight(inertia, damping, interval_s / 4.0, &calm());
        let tolerance = keys::Tolerance { place_m: 0.0008, turn_rad: TOLERANCE };
        let (places, turns) =
            keys::keyed(&keys::knots(&flight.poses, None, DVec3::ZERO), 0.0, tolerance).unwrap();
        let most = |flight: &Flight, until: usize| {
            let apart = flight.poses[..until].iter().map(|pose| {
                let turn = turns.at(pose.time_s);
                let chord = (turn - pose.turn).length().min((turn + pose.turn).length());
                ((places.at(pose.time_s) - pose.middle).length(), 2.0 * chord)
            });
            apart.fold((0.0_f64, 0.0_f64), |most, (place, turn)| (most.0.max(place), most.1.max(turn)))
        };
        let (place_m, turn_rad) = most(&flight, flight.poses.len());
        assert!(place_m < 0.00081 && turn_rad < 1.01 * TOLERANCE, "{place_m} {turn_rad}");
        // Finer steps are the same flight for the first seconds, by
        // `shorter_intervals_end_in_the_same_place`.
        let (place_m, turn_rad) = most(&fine, (1.5 / (interval_s / 4.0)) as usize);
        assert!(place_m < 0.001 && turn_rad < 1.5 * TOLERANCE, "{place_m} {turn_rad}");
        assert!(places.times_s().len() < flight.poses.len() && turns.times_s().len() < flight.poses.len());
    }
}

#[test]
fn more_leaves_leave_the_others_flights_as_they_are() {
    let few = Fall { count: 20, ..fall(every_way(), storm(), level()) }.fly(&|_| {});
    let many = fall(every_way(), storm(), level()).fly(&|_| {});
    assert_eq!(few, many[..20]);
}

/// A leaf of 8 by 6 cm in one of the ways, high above the ground.
fn lone_flight(inertia: f64, damping: f64, interval_s: f64, wind: &Wind) -> Flight {
    let quiet = FallMotion { flutter: 1.0.into(), ..FallMotion::default() };
    let (_, manner, _) = manner::choose(&quiet, Chance::of(1, 1), 0);
    let leaf = Leaf {
        plate: plate::Plate { inertia, damping, curl: 0.0 },
        scales: plate::Scales::new(0.06, 0.08),
        speed_gain: 1.0,
        manner: leaf::Manner { yaw_rad_per_s: 0.0, ..manner },
        middle: DVec3::Y * 4.0,
        release_s: 0.0,
        heading: [1.0, 0.0],
        slope: [0.8, 0.6],
        twist: DQuat::IDENTITY,
        outline: vec![DVec3::ZERO],
        rests: [DVec3::Y, DVec3::NEG_Y],
        reach_m: 0.0,
        clearance_m: 0.0,
    };
    let (ground, obstacles) = (Ground::new(0.0, Vec::new(), Vec::new()), Obstacles::default());
    fly_alone(
        leaf,
        interval_s,
        Surroundings { wind, ground: &ground, obstacles: &obstacles, speed_gain: &1.0.into() },
    )
}

/// A flight with steps of numbers that have no neighbours.
fn fly_alone(leaf: Leaf, interval_s: f64, around: Surroundings<'_>) -> Flight {
    let mut journey = match flight::Journey::released(leaf, interval_s, around) {
        Ok(journey) => journey,
        Err(flight) => return flight,
    };
    loop {
        let flight::Leg { plate, mut state, weight, time, steps } = journey.depart(around);
        for _ in 0..steps {
            state = plate.step(state, weight, time);
        }
        if let Some(flight) = journey.arrive(state, around) {
            return flight;
        }
    }
}

#[test]
fn leaves_fly_together_as_they_fly_alone() {
    let fall = fall(every_way(), storm(), hills());
    let mut flown = 0;
    together::fly((0..30).map(|number| fall.leaf(number)), fall.surroundings(), |place, flight| {
        let leaf = fall.leaf(place as u32);
        let interval_s = leaf.interval_s();
        assert_eq!(flight, fly_alone(leaf, interval_s, fall.surroundings()), "leaf {place}");
        flown += 1;
    });
    assert_eq!(flown, 30);
}

#[test]
fn shorter_intervals_end_in_the_same_place() {
    // A second and a half. In eddies flutter is chaotic, so a steady leaf stands for the storm.
    let gusts = Wind::new(
        DVec3::X,
        Gusts { speed_m_per_s: DVec3::X * 2.0, every_s: 3.0 },
        Eddies { speed_m_per_s: 0.0, size_m: 2.0 },
        5,
    );
    let flights =
        [(0.8, 0.2, calm(), 1e-5, 0.0), (0.8, 0.2, gusts, 1e-2, 8.0), (0.3, 8.0, storm(), 1e-2, 3.0)];
    for (inertia, damping, wind, tolerance_m, gain) in flights {
        let flight = |rate: usize| lone_flight(inertia, damping, 1.0 / rate as f64, &wind);
        let end = |rate: usize| flight(rate).poses[3 * rate / 2].middle;
        let finest = end(1920);
        let (coarse, fine) = ((end(60) - finest).length(), (end(240) - finest).length());
        assert!(coarse < tolerance_m && fine * gain <= coarse, "{coarse} {fine}");
    }
}

#[test]
fn steady_leaves_sink_a_little_slower_than_drag_on_a_level_plate_allows() {
    let flight = lone_flight(0.3, 8.0, 1.0 / 60.0, &calm());
    let (first, last) = (flight.poses[60], flight.poses[flight.poses.len() - 1]);
    let sinks = (first.middle.y - last.middle.y) / (last.time_s - first.time_s);
    let level = f64::sqrt(2.0 * 0.08 * plate::GRAVITY / (2.4 * plate::AIR_DENSITY));
    assert!((0.75..1.0).contains(&(sinks / level)), "{sinks} of {level} m/s");
}

#[test]
fn the_wind_carries_leaves_along() {
    let wind = Wind::new(
        DVec3::new(1.5, 0.0, -0.5),
        Gusts { speed_m_per_s: DVec3::ZERO, every_s: 1.0 },
        Eddies { speed_m_per_s: 0.0, size_m: 1.0 },
        0,
    );
    let flight = lone_flight(0.3, 8.0, 1.0 / 60.0, &wind);
    let (first, last) = (flight.poses[60], flight.poses[flight.poses.len() - 1]);
    let drift = (last.middle - first.middle) / (last.time_s - first.time_s);
    assert!((drift.x - 1.5).abs() < 0.15 && (drift.z + 0.5).abs() < 0.05, "{drift}");
}

#[test]
fn each_way_of_falling_is_what_it_is_called() {
    let turns = |motion: FallMotion| {
        let fall = fall(motion, calm(), Ground::new(-20.0, Vec::new(), Vec::new()));
        let leaves = bake(&Fall { release_s: (0.0, 0.0), count: 40, ..fall });
        // How often the upper side comes to lie below, a leaf and second.
        let flips = leaves.iter().map(|leaf| {
            let up = |at: u32| (leaf.rotation.at(2.0 + f64::from(at) / 60.0) * DVec3::Y).y > 0.0;
            (0..240).filter(|&at| up(at) != up(at + 1)).count()
        });
        flips.sum::<usize>() as f64 / 40.0 / 4.0
    };
    // From any slope, so that a few turn over once at first.
    assert!(turns(FallMotion { steady: 1.0.into(), ..FallMotion::default() }) < 0.02);
    let (flutter, tumble) = (
        turns(FallMotion { flutter: 1.0.into(), ..FallMotion::default() }),
        turns(FallMotion { tumble: 1.0.into(), ..FallMotion::default() }),
    );
    assert!(flutter < 0.5 && tumble > 1.5, "{flutter} {tumble}");
    let chaotic = turns(FallMotion { chaotic: 1.0.into(), ..FallMotion::default() });
    assert!(flutter < chaotic, "{chaotic}");
}

#[test]
fn helices_keep_their_radius_and_spirals_widen() {
    let directions = |motion: FallMotion| {
        let fall = fall(motion, calm(), Ground::new(-40.0, Vec::new(), Vec::new()));
        let leaves = bake(&Fall { release_s: (0.0, 0.0), count: 30, ..fall });
        // Mean speed of turning of the way over the ground, early and late.
        let turning = |from_s: f64| {
            let sum: f64 = (leaves.iter())
                .map(|leaf| {
                    let way = |at_s: f64| {
                        let step = leaf.translation.at(at_s + 1.0) - leaf.translation.at(at_s);
                        f64::atan2(step.z, step.x)
                    };
                    let turned = way(from_s + 0.5) - way(from_s);
                    ((turned + PI).rem_euclid(2.0 * PI) - PI).abs() / 0.5
                })
                .sum();
            sum / 30.0
        };
        (turning(2.0), turning(12.0))
    };
    let (early, late) = directions(FallMotion { helical: 1.0.into(), ..FallMotion::default() });
    assert!((0.7..1.4).contains(&(late / early)) && early > 1.0, "{early} {late}");
    let (early, late) = directions(FallMotion { spiral: 1.0.into(), ..FallMotion::default() });
    assert!(late < 0.6 * early, "{early} {late}");
}

#[test]
fn faster_leaves_fall_the_same_way_in_less_time() {
    // Twice the speed is four times the weight: in calm air the same path.
    let slow = bake(&Fall { count: 20, ..fall(every_way(), calm(), level()) });
    let fast = bake(&Fall { speed_gain: 2.0.into(), count: 20, ..fall(every_way(), calm(), level()) });
    let duration_s = |leaf: &Fallen| {
        leaf.translation.times_s().last().unwrap() - leaf.translation.times_s().first().unwrap()
    };
    let ratio: f64 =
        slow.iter().zip(&fast).map(|(slow, fast)| duration_s(slow) / duration_s(fast)).sum::<f64>() / 20.0;
    assert!((1.7..2.3).contains(&ratio), "{ratio}");
}

#[test]
fn keys_are_few() {
    let leaves = bake(&fall(every_way(), storm(), level()));
    let keys: usize = leaves.iter().map(|leaf| leaf.translation.times_s().len()).sum();
    let seconds: f64 =
        leaves.iter().map(|leaf| leaf.translation.times_s().last().unwrap() - leaf.release_s).sum();
    // Seconds that strips take for the same ways.
    let seconds = seconds / OF_A_STRIP.sqrt();
    assert!(keys as f64 / seconds < 18.0, "{} keys a second", keys as f64 / seconds);
}
