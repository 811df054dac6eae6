//! Thin plate that falls through still air in two dimensions. In go a state and a time step, out comes the
//! next state. Invariant: it uses only sums, products, quotients and square roots, which every machine rounds
//! alike, so chaotic motion is the same everywhere.
//!
//! Andersen, Pesavento & Wang, "Analysis of transitions between fluttering, tumbling and steady descent
//! of falling cards", J. Fluid Mech. 541 (2005), 91-104, equations (4.7)-(4.9) and (5.1)-(5.3): an
//! ellipse in the limit of no thickness. Lengths are in half chords, velocities in
//! `sqrt(2 areal_mass g / (pi air_density))`, see [`Scales`].

use super::lanes::Number;
use std::f64::consts::{FRAC_1_PI, FRAC_2_PI, PI};

/// Translational circulation, of the paper's section 6.
const C_T: f64 = 1.2;
/// Rotational circulation.
const C_R: f64 = PI;
/// Drag: the mean over all angles of attack, and half the difference between broadside and edgewise.
const A: f64 = 1.4;
const B: f64 = 1.0;
/// Aerodynamic torque on a turning plate; [`Plate::damping`] is its linear part.
const MU_2: f64 = 0.2;

/// Air at 15 degrees Celsius and sea level, kg/m^3.
pub(super) const AIR_DENSITY: f64 = 1.225;
/// Standard gravity, m/s^2.
pub(super) const GRAVITY: f64 = 9.806_65;

/// Dimensionless parameters of a plate, or of one a lane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plate<N = f64> {
    /// I*, its mass over that of the displaced air: decides between flutter and tumbling.
    pub(super) inertia: N,
    /// mu_1 of the paper: damping of slow rotation.
    pub(super) damping: N,
    /// Arch of the chord, from edge to edge, radians; convex towards +normal.
    pub(super) curl: N,
}

/// mu_1 of the paper's section 6.
pub(super) const PAPER_DAMPING: f64 = 0.2;

/// Units of length and speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    /// Half the chord, metres.
    pub(super) length_m: f64,
    /// Speed at which weight and the air's forces balance, m/s.
    pub(super) speed_m_per_s: f64,
}

impl Scales {
    /// Units of a plate in air.
    pub(super) fn new(chord_m: f64, areal_mass_kg_per_m2: f64) -> Self {
        let speed_squared = 2.0 * areal_mass_kg_per_m2 * GRAVITY / (PI * AIR_DENSITY);
        Self { length_m: 0.5 * chord_m, speed_m_per_s: speed_squared.sqrt() }
    }

    /// Time to move by one length at that speed, seconds.
    pub(super) fn time_s(self) -> f64 {
        self.length_m / self.speed_m_per_s
    }
}

/// I* of a uniform plate: its mass over that of a cylinder of air as wide as the chord.
pub(super) fn inertia(chord_m: f64, areal_mass_kg_per_m2: f64) -> f64 {
    4.0 * areal_mass_kg_per_m2 / (PI * AIR_DENSITY * chord_m)
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct State<N = f64> {
    /// Velocity relative to the air, along the chord and along the normal.
    pub(super) u: N,
    pub(super) v: N,
    /// Angular velocity.
    pub(super) w: N,
    /// The chord's direction (cosine, sine of its angle to the horizontal), of unit length.
    pub(super) cos: N,
    pub(super) sin: N,
    /// Position of the centre relative to the air.
    pub(super) x: N,
    pub(super) y: N,
}

impl State {
    /// State at rest in the air; the chord's angle has this cosine and sine.
    pub(super) fn at_rest([cos, sin]: [f64; 2]) -> Self {
        Self { u: 0.0, v: 0.0, w: 0.0, cos, sin, x: 0.0, y: 0.0 }
    }

    /// State with another velocity, given as horizontal and upward components.
    pub(super) fn with_velocity(self, horizontal: f64, upward: f64) -> Self {
        let u = horizontal * self.cos + upward * self.sin;
        Self { u, v: upward * self.cos - horizontal * self.sin, ..self }
    }
}

impl<N: Number> State<N> {
    #[inline(always)] // Lanes stay in registers.
    fn plus(self, rate: Self, time: N) -> Self {
        Self {
            u: self.u + time * rate.u,
            v: self.v + time * rate.v,
            w: self.w + time * rate.w,
            cos: self.cos + time * rate.cos,
            sin: self.sin + time * rate.sin,
            x: self.x + time * rate.x,
            y: self.y + time * rate.y,
        }
    }
}

impl Plate {
    /// Time in which damping alone reduces a slow rotation to a third.
    pub(super) fn damping_time(&self) -> f64 {
        0.25 * (self.inertia + 0.5) / self.damping
    }
}

impl<N: Number> Plate<N> {
    /// State after `time`, with a weight `(horizontal, upward)` of `(0, -1)` unless the air accelerates.
    /// Classical fourth-order Runge-Kutta.
    #[inline(always)] // Lanes stay in registers.
    pub(super) fn step(&self, state: State<N>, weight: [N; 2], time: N) -> State<N> {
        let (half, third, sixth) = (time * 0.5, time.map(|time| time / 3.0), time.map(|time| time / 6.0));
        let k1 = self.rate(state, weight);
        let k2 = self.rate(state.plus(k1, half), weight);
        let k3 = self.rate(state.plus(k2, half), weight);
        let k4 = self.rate(state.plus(k3, time), weight);
        let mut next = state.plus(k1, sixth).plus(k2, third).plus(k3, third).plus(k4, sixth);
        // Normalization by a step of Newton's method, which squares the error.
        let scale = (next.cos * next.cos + next.sin * next.sin).map(|square| 1.5 - 0.5 * square);
        next.cos = next.cos * scale;
        next.sin = next.sin * scale;
        next
    }

    /// Time derivative of the state.
    #[inline(always)] // Lanes stay in registers.
    fn rate(&self, state: State<N>, weight: [N; 2]) -> State<N> {
        let State { u, v, w, cos, sin, .. } = state;
        let i = self.inertia;
        let speed = (u * u + v * v).map(f64::sqrt);
        // Any finite factor is right at rest.
        let over_speed =
            speed.map(|speed| if speed > f64::MIN_POSITIVE { speed } else { f64::MIN_POSITIVE }.recip());
        // (4.7). The last term is not the paper's: a chord with the arch `curl` has the lift of one that is
        // turned by a quarter of it, and no moment about its centre (thin aerofoils, Glauert 1926, ch. 7).
        let lifting = -u * v * over_speed + self.curl * 0.25 * u;
        let circulation = (lifting * C_T + w * C_R) * FRAC_2_PI;
        // (4.8): drag over velocity.
        let drag = (speed * A - (u * u - v * v) * B * over_speed) * FRAC_1_PI;
        // (4.9)
        let torque = (self.damping + w.map(f64::abs) * MU_2) * w;
        let weight_u = weight[0] * cos + weight[1] * sin;
        let weight_v = weight[1] * cos - weight[0] * sin;
        // Divisions independent of the state, computed first.
        let over_i = i.map(f64::recip);
        let over_added = i.map(|i| (i + 1.0).recip());
        let over_turned = i.map(|i| (0.25 * (i + 0.5)).recip());
        State {
            // (5.1)-(5.3)
            u: (i.map(|i| i + 1.0) * w * v - circulation * v + weight_u - drag * u) * over_i,
            v: (-i * w * u + circulation * u + weight_v - drag * v) * over_added,
            w: (-u * v - torque) * over_turned,
            cos: -w * sin,
            sin: w * cos,
            x: u * cos - v * sin,
            y: u * sin + v * cos,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, TAU};

    const DOWN: [f64; 2] = [0.0, -1.0];

    /// Speed of a flat plate that sinks broadside, its weight borne by drag alone: `pi = (A + B) speed^2`.
    fn broadside_speed() -> f64 {
        (PI / (A + B)).sqrt()
    }

    fn paper(inertia: f64) -> Plate {
        Plate { inertia, damping: PAPER_DAMPING, curl: 0.0 }
    }

    fn released(angle: f64) -> State {
        let (sin, cos) = angle.sin_cos();
        State::at_rest([cos, sin])
    }

    /// The states from `from` to `to`, `step` apart, of a plate released at 45 degrees.
    fn flight(plate: Plate, from: f64, to: f64, step: f64) -> Vec<State> {
        let mut state = released(0.25 * PI);
        let mut states = Vec::new();
        for index in 0..(to / step) as usize {
            if index as f64 * step >= from {
                states.push(state);
            }
            state = plate.step(state, DOWN, step);
        }
        states
    }

    /// Angle turned through from the first state to each.
    fn angles(states: &[State]) -> Vec<f64> {
        let mut turned = 0.0;
        states
            .windows(2)
            .map(|pair| {
                let (a, b) = (pair[0], pair[1]);
                turned += f64::atan2(a.cos * b.sin - a.sin * b.cos, a.cos * b.cos + a.sin * b.sin);
                turned
            })
            .collect()
    }

    /// Half the width of the swing, and whole turns.
    fn swing_and_turns(states: &[State]) -> (f64, f64) {
        let angles = angles(states);
        let (low, high) =
            angles.iter().fold((0.0_f64, 0.0_f64), |(low, high), &angle| (low.min(angle), high.max(angle)));
        (0.5 * (high - low), angles.last().copied().unwrap_or(0.0).abs() / TAU)
    }

    fn sinking(states: &[State], step: f64) -> f64 {
        (states[0].y - states[states.len() - 1].y) / (step * (states.len() - 1) as f64)
    }

    /// Autocorrelation of the angular velocity at a lag.
    fn likeness(states: &[State], lag: usize) -> f64 {
        let mean = states.iter().map(|state| state.w).sum::<f64>() / states.len() as f64;
        let count = states.len() - lag;
        let product = |a: usize, b: usize| (states[a].w - mean) * (states[b].w - mean);
        let whole: f64 = (0..count).map(|at| product(at, at)).sum();
        (0..count).map(|at| product(at, at + lag)).sum::<f64>() / whole
    }

    /// Time after which the angular velocity is most alike itself, first maximum above one half.
    fn period(states: &[State], step: f64) -> f64 {
        let likeness = |lag| likeness(states, lag);
        let mut lag = (1.0 / step) as usize;
        while !(likeness(lag) > 0.5 && likeness(lag) > likeness(lag - 1) && likeness(lag) > likeness(lag + 1))
        {
            lag += 1;
        }
        lag as f64 * step
    }

    #[test]
    fn a_flat_plate_sinks_broadside_at_the_speed_that_drag_allows() {
        // Level and without a disturbance it stays level, stable or not.
        let mut state = released(0.0);
        for _ in 0..3000 {
            state = paper(1.0).step(state, DOWN, 0.02);
        }
        assert!((state.v + broadside_speed()).abs() < 1e-12, "{state:?}");
        assert_eq!((state.u, state.w, state.x), (0.0, 0.0, 0.0));
        // In metres: the weight is the drag on the whole width, coefficient A + B = 2.4.
        let (chord_m, areal_mass) = (0.06, 0.08);
        let speed = broadside_speed() * Scales::new(chord_m, areal_mass).speed_m_per_s;
        let drag = 0.5 * AIR_DENSITY * speed * speed * chord_m * (A + B);
        assert!((drag / (areal_mass * chord_m * GRAVITY) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn edgewise_it_falls_faster_by_the_ratio_of_drags() {
        let mut state = State::at_rest([0.0, 1.0]);
        for _ in 0..6000 {
            state = paper(1.0).step(state, DOWN, 0.02);
        }
        assert!((state.u + (PI / (A - B)).sqrt()).abs() < 1e-12, "{state:?}");
        assert_eq!((state.v, state.w), (0.0, 0.0));
    }

    #[test]
    fn at_first_weight_and_added_mass_alone_matter() {
        // Over a moment from rest neither lift nor drag has grown: along the chord it is as heavy as it
        // is, along the normal it carries the added mass of the air, (5.1) and (5.2).
        let (plate, time) = (paper(0.8), 1e-4);
        let state = plate.step(released(0.7), DOWN, time);
        assert!((state.u + 0.7_f64.sin() / 0.8 * time).abs() < 1e-9);
        assert!((state.v + 0.7_f64.cos() / 1.8 * time).abs() < 1e-9);
        assert!(state.w.abs() < 1e-7);
    }

    #[test]
    fn drag_and_torque_alone_take_energy() {
        // Lift and added mass do no work in all: height lost is what drag and torque have taken.
        let (plate, step) = (paper(1.1), 0.002);
        let energy = |s: State| {
            let i = plate.inertia;
            0.5 * (i * s.u * s.u + (i + 1.0) * s.v * s.v + 0.25 * (i + 0.5) * s.w * s.w) + s.y
        };
        let loss = |s: State| {
            let speed = (s.u * s.u + s.v * s.v).sqrt();
            let drag = (A * speed - B * (s.u * s.u - s.v * s.v) / speed.max(1e-300)) / PI;
            drag * speed * speed + (plate.damping + MU_2 * s.w.abs()) * s.w * s.w
        };
        let states = flight(plate, 0.0, 20.0, step);
        let lost: f64 = states.windows(2).map(|pair| 0.5 * step * (loss(pair[0]) + loss(pair[1]))).sum();
        let (first, last) = (states[0], states[states.len() - 1]);
        assert!((energy(first) - energy(last) - lost).abs() < 1e-4 * lost, "{lost}");
    }

    #[test]
    fn halving_the_step_divides_the_error_by_sixteen() {
        // While it tumbles one way; where the turn changes its sense the torque has a kink.
        let tumbling = flight(paper(1.4), 300.0, 300.1, 0.02)[0];
        let end = |steps: usize| {
            (0..steps).fold(tumbling, |state, _| paper(1.4).step(state, DOWN, 20.0 / steps as f64))
        };
        let finest = end(64_000);
        let error = |steps| f64::hypot(end(steps).x - finest.x, end(steps).y - finest.y);
        let (coarse, fine) = (error(400), error(800));
        assert!(14.0 < coarse / fine && coarse / fine < 18.0, "{coarse} {fine}");
    }

    #[test]
    fn motions_are_those_of_the_papers_figure_3() {
        // I* = 1.1 flutters, 1.4 tumbles, 1.45 tumbles with twice the period, 2.2 is chaotic, 3.0
        // flutters broadside on (figure 3 and section 6).
        let step = 0.02;
        let motion = |inertia| flight(paper(inertia), 200.0, 500.0, step);
        let (swing, turns) = swing_and_turns(&motion(1.1));
        assert!(1.3 < swing && swing < FRAC_PI_2 && turns < 0.5, "{swing} {turns}");
        for inertia in [1.4, 1.45] {
            let (_, turns) = swing_and_turns(&motion(inertia));
            assert!(turns > 20.0, "{inertia}: {turns}");
        }
        let half_turn = |inertia| {
            let states = motion(inertia);
            let (_, turns) = swing_and_turns(&states);
            likeness(&states, (300.0 / (2.0 * turns) / step).round() as usize)
        };
        let (plain, doubled) = (half_turn(1.4), half_turn(1.45));
        assert!(plain > 0.98, "{plain}");
        assert!((0.5..0.9).contains(&doubled), "{doubled}");
        let (swing, turns) = swing_and_turns(&motion(2.2));
        assert!(swing > TAU && turns < 0.5 * swing / PI, "{swing} {turns}");
        let (swing, turns) = swing_and_turns(&motion(3.0));
        assert!(1.0 < swing && swing < FRAC_PI_2 && turns < 0.5, "{swing} {turns}");
    }

    #[test]
    fn between_flutter_and_tumble_the_period_grows_without_bound() {
        // A heteroclinic bifurcation (the paper's section 7): ever longer on edge as it comes near.
        let step = 0.05;
        let flutter = |inertia| period(&flight(paper(inertia), 200.0, 500.0, step), step);
        let (far, near, nearest) = (flutter(1.0), flutter(1.15), flutter(1.2));
        assert!(far < near && near < nearest && nearest > 1.5 * far, "{far} {near} {nearest}");
        let tumbles = |inertia| swing_and_turns(&flight(paper(inertia), 200.0, 500.0, step)).1 > 5.0;
        assert!(!tumbles(1.2) && tumbles(1.26), "the transition lies between I* = 1.20 and 1.26");
        // And the descent is fastest there.
        let sinks = |inertia| sinking(&flight(paper(inertia), 200.0, 500.0, step), step);
        assert!(sinks(1.2) > 1.5 * sinks(1.0) && sinks(1.2) > 1.5 * sinks(1.4));
    }

    #[test]
    fn strips_tumble_as_fast_as_square_root_of_thickness_over_width() {
        // Mahadevan, Ryu & Samuel, "Tumbling cards", Phys. Fluids 11 (1999): frequency ~ d^(1/2) / w.
        // At one I*, thickness goes with width: then frequency goes as width^(-1/2).
        let turns_per_s = |chord_m: f64| {
            let areal_mass = 1.4 * PI * AIR_DENSITY * chord_m / 4.0;
            assert!((inertia(chord_m, areal_mass) - 1.4).abs() < 1e-12);
            let (_, turns) = swing_and_turns(&flight(paper(1.4), 200.0, 500.0, 0.05));
            (turns / 300.0 / Scales::new(chord_m, areal_mass).time_s(), areal_mass)
        };
        let ((narrow, thin), (wide, thick)) = (turns_per_s(0.02), turns_per_s(0.08));
        let predicted = (thin / thick).sqrt() / (0.02 / 0.08);
        assert!((narrow / wide / predicted - 1.0).abs() < 1e-9);
        // A strip of paper 2 cm wide turns some ten times a second.
        assert!((2.0..20.0).contains(&narrow), "{narrow}");
    }

    #[test]
    fn an_arched_plate_glides_on_its_hollow_side() {
        // Moving edgewise it is pushed towards its back, whichever way it goes.
        let arched = Plate { curl: 0.5, ..paper(1.0) };
        for u in [-1.0, 1.0] {
            let state = State { u, ..released(0.0) };
            let (flat, lifted) = (paper(1.0).step(state, DOWN, 0.01), arched.step(state, DOWN, 0.01));
            assert!(lifted.v > flat.v + 1e-4);
        }
    }
}
