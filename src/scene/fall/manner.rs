//! Modes in which leaves fall, and their weights. In go weights and draws, out come a plate's inertia and
//! manner. Invariant: a mode sets the plate's inertia, which decides the motion. Only rotation and lean of
//! the plane of fall are added.
//!
//! The six are those of Xie & Miyata, "Stochastic modeling of immersed rigid-body dynamics" (SIGGRAPH Asia
//! 2013 briefs). The first four of them are the regimes of Field, Klaus, Moore & Nori, Nature 388 (1997).

use super::leaf::Manner;
use super::plate::PAPER_DAMPING;
use crate::description::ron::FallMotion;
use crate::math::Chance;
use std::f64::consts::TAU;

/// Damping of steady descent, in place of mu_1 = 0.2; chosen for looks, as the paper's plate never sinks
/// steadily.
const STEADY_DAMPING: f64 = 8.0;

#[derive(Clone, Copy)]
enum Way {
    Steady,
    Flutter,
    Tumble,
    Chaotic,
    Helical,
    Spiral,
}

fn shares(motion: &FallMotion) -> [(Way, f64); 6] {
    [
        (Way::Steady, motion.steady.si()),
        (Way::Flutter, motion.flutter.si()),
        (Way::Tumble, motion.tumble.si()),
        (Way::Chaotic, motion.chaotic.si()),
        (Way::Helical, motion.helical.si()),
        (Way::Spiral, motion.spiral.si()),
    ]
}

pub(crate) fn sum(motion: &FallMotion) -> f64 {
    shares(motion).iter().map(|(_, share)| share).sum()
}

/// Inertia, manner and damping of one leaf, with draws from `first` on; not all weights are zero.
pub(crate) fn choose(motion: &FallMotion, chance: Chance, first: u64) -> (f64, Manner, f64) {
    let mut left = chance.at(first) * sum(motion);
    let chosen = shares(motion).into_iter().find(|(_, share)| {
        left -= share;
        left < 0.0
    });
    let way = chosen.map_or(Way::Flutter, |(way, _)| way);
    // Within the regimes of the equations, in and around the paper's figure 3.
    let (low, high) = match way {
        Way::Steady => (0.2, 0.5),
        Way::Flutter => (0.6, 1.15),
        Way::Tumble | Way::Helical | Way::Spiral => (1.26, 1.42),
        Way::Chaotic => (1.5, 2.5),
    };
    let damping = if matches!(way, Way::Steady) { STEADY_DAMPING } else { PAPER_DAMPING };
    (low + (high - low) * chance.at(first + 1), manner(way, chance, first + 2), damping)
}

/// Inertia, manner and damping of a leaf whose own inertia decides.
pub(crate) fn natural(inertia: f64, chance: Chance, first: u64) -> (f64, Manner, f64) {
    (inertia, manner(Way::Chaotic, chance, first + 2), PAPER_DAMPING)
}

fn manner(way: Way, chance: Chance, first: u64) -> Manner {
    let draw = |number: u64, low: f64, high: f64| low + (high - low) * chance.at(first + number);
    let side = if chance.at(first) < 0.5 { -1.0 } else { 1.0 };
    let (yaw, widening_per_s, bank) = match way {
        Way::Steady => (draw(1, 0.2, 1.2), 0.0, 0.0),
        Way::Helical => (draw(1, 1.5, 3.5), 0.0, draw(2, 0.2, 0.5)),
        Way::Spiral => (draw(1, 3.0, 5.0), draw(3, 0.3, 0.6), draw(2, 0.2, 0.5)),
        Way::Flutter | Way::Tumble | Way::Chaotic => (draw(1, 0.0, 0.5), 0.0, 0.0),
    };
    let (sin, cos) = libm::sincos(TAU * chance.at(first + 6));
    Manner {
        yaw_rad_per_s: side * yaw,
        widening_per_s,
        bank: side * bank,
        sway: draw(4, 0.1, 0.35),
        sway_rad_per_s: draw(5, 1.5, 4.0),
        sway_phase: [cos, sin],
    }
}
