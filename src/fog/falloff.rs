//! Fog that thins out with height. In goes a line through it, out comes the amount of fog along the line.
//! Invariant: all lengths are closed forms without cancellation, for any slope of the line, any thinness of
//! the fog and any height of the line's start.

use super::beer_lambert::mean_transmittance;
use crate::math::Ray;
use glam::{DAffine3, DVec3};

/// Finite length for an infinite way through fog: its product with 0 is 0, and even fog of 1e-15 per metre is
/// opaque over it.
pub(super) const ENDLESS_M: f64 = 1e200;

/// Density relative to that of the base: `exp(-max(u, 0))`, where `u` is the height above the base in scale
/// heights.
#[derive(Clone, Copy, Debug)]
pub struct Falloff {
    /// `u` at the origin of relative space.
    at_origin: f64,
    /// Growth of `u` per metre.
    gradient: DVec3,
    /// The base as the y coordinate of the space that defined it.
    pub(super) base_y: f64,
}

impl Falloff {
    /// Falloff above the plane `y = base_y` of a node's space; `None` if that space is flat.
    ///
    /// Heights are metres at right angles to the plane, for any scale of the node.
    pub fn new(relative_from_node: DAffine3, base_y: f64, scale_height_m: f64) -> Option<Self> {
        let node_from_relative = relative_from_node.inverse();
        let y_per_m = node_from_relative.matrix3.row(1);
        let per_y = 1.0 / (y_per_m.length() * scale_height_m);
        let falloff = Self {
            at_origin: (node_from_relative.translation.y - base_y) * per_y,
            gradient: y_per_m * per_y,
            base_y,
        };
        (falloff.at_origin.is_finite() && falloff.gradient.is_finite()).then_some(falloff)
    }

    /// The direction in which density falls, a unit vector, and its scale height, metres.
    pub(super) fn up(&self) -> (DVec3, f64) {
        let per_m = self.gradient.length();
        (self.gradient / per_m, 1.0 / per_m)
    }

    /// Heights along a ray.
    pub fn along(&self, ray: &Ray) -> Climb {
        Climb {
            start: self.gradient.dot(ray.origin) + self.at_origin,
            per_m: self.gradient.dot(ray.direction),
        }
    }
}

/// Heights along a ray, in scale heights above the base: `start + per_m * t`.
#[derive(Clone, Copy, Debug)]
pub struct Climb {
    pub(super) start: f64,
    pub(super) per_m: f64,
}

impl Climb {
    /// The height at a distance.
    pub fn height(&self, t: f64) -> f64 {
        self.start + self.per_m * t
    }

    /// Density at a distance, relative to that of the base.
    pub fn density(&self, t: f64) -> f64 {
        (-self.height(t).max(0.0)).exp()
    }

    /// Distance at which the ray crosses the base, which may be negative; not finite if it does not.
    pub fn at_base(&self) -> f64 {
        -self.start / self.per_m
    }

    /// `integral of density(t) dt`: metres of fog at the base's density with the same optical depth.
    pub fn metres_at_base_density(&self, start: f64, end: f64) -> f64 {
        let (u, k, length) = (self.height(start), self.per_m, end - start);
        if length.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return 0.0;
        }
        // Distance to its crossing of the base, if it has one.
        let to_base = if (u < 0.0) == (k > 0.0) { (-u / k).abs() } else { f64::INFINITY };
        let metres = match (u < 0.0, to_base < length) {
            (true, false) => length,
            (true, true) => to_base + above_base(0.0, k, length - to_base),
            (false, false) => above_base(u, k, length),
            (false, true) => above_base(u, k, to_base) + (length - to_base),
        };
        metres.min(ENDLESS_M)
    }

    /// The inverse: distance from `start` over which so many metres are gathered. Infinite if that never
    /// happens, or not within the range of an exponential.
    pub fn distance_to_gather(&self, start: f64, metres: f64) -> f64 {
        let (u, k) = (self.height(start), self.per_m);
        if u < 0.0 {
            let below = if k > 0.0 { -u / k } else { f64::INFINITY };
            return if metres <= below { metres } else { below + distance_above(0.0, k, metres - below) };
        }
        if k < 0.0 {
            let above = u / -k;
            let gathered = above_base(u, k, above);
            if metres > gathered {
                return above + (metres - gathered);
            }
        }
        distance_above(u, k, metres)
    }
}

/// Metres at base density over a line above the base that starts at height `u` and climbs by `k` per metre.
fn above_base(u: f64, k: f64, length: f64) -> f64 {
    if length <= 0.0 {
        return 0.0;
    }
    if length.is_finite() {
        let change = k * length;
        return length * (-(u + change.min(0.0))).exp() * mean_transmittance(change.abs());
    }
    if k > 0.0 { (-u).exp() / k } else { (-u).exp() * ENDLESS_M }
}

/// Solves `above_base(u, k, x) = metres` for x.
fn distance_above(u: f64, k: f64, metres: f64) -> f64 {
    let level = metres * u.exp();
    let share = k * level;
    if share >= 1.0 || !level.is_finite() {
        return f64::INFINITY;
    }
    // -ln(1 - s) / s, which tends to 1 on level lines.
    if share == 0.0 { level } else { level * (-share).ln_1p() / -share }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::gauss_legendre;
    use proptest::prelude::*;

    /// Gauss-Legendre on a thousand pieces, cut where the ray passes through the base.
    fn dense(climb: Climb, start: f64, end: f64) -> f64 {
        let cut = climb.at_base();
        let cut = if cut > start && cut < end { cut } else { end };
        let over = |from: f64, to: f64| -> f64 {
            let half = 0.5 * (to - from) / 1000.0;
            let middles = (0..1000).map(|piece| from + f64::from(2 * piece + 1) * half);
            let nodes = middles.flat_map(|middle| gauss_legendre(8).iter().map(move |node| (middle, node)));
            nodes.map(|(middle, (x, weight))| half * weight * climb.density(middle + x * half)).sum()
        };
        over(start, cut) + over(cut, end)
    }

    proptest! {
        #[test]
        fn lengths_equal_quadrature(
            start in -30.0..30.0_f64, exponent in -14.0..0.5_f64, falls: bool, from in 0.0..50.0_f64,
            length in 0.001..60.0_f64,
        ) {
            let per_m = 10_f64.powf(exponent) * if falls { -1.0 } else { 1.0 };
            let climb = Climb { start, per_m };
            let (found, expected) = (climb.metres_at_base_density(from, from + length), dense(climb, from, from + length));
            prop_assert!((found - expected).abs() <= 1e-11 * expected, "{climb:?}: {found} {expected}");
            let again = climb.metres_at_base_density(from, from + climb.distance_to_gather(from, found));
            prop_assert!((again / found - 1.0).abs() < 1e-9, "{climb:?}: {again} {found}");
        }
    }

    #[test]
    fn the_column_above_a_point_is_finite_and_level_ways_are_endless() {
        let up = Climb { start: 2.0, per_m: 0.1 };
        assert!(
            (up.metres_at_base_density(0.0, f64::INFINITY) / ((-2.0_f64).exp() * 10.0) - 1.0).abs() < 1e-14
        );
        let from_below = Climb { start: -3.0, per_m: 0.1 };
        assert!((from_below.metres_at_base_density(0.0, f64::INFINITY) - 40.0).abs() < 1e-12);
        for endless in [Climb { start: 2.0, per_m: 0.0 }, Climb { start: 1e4, per_m: -0.1 }] {
            assert!(endless.metres_at_base_density(0.0, f64::INFINITY) > 1e150);
        }
        // So high that no fog is left.
        assert_eq!(Climb { start: 1e4, per_m: 0.0 }.metres_at_base_density(0.0, f64::INFINITY), 0.0);
        assert_eq!(Climb { start: 1e4, per_m: 1.0 }.metres_at_base_density(0.0, f64::INFINITY), 0.0);
    }

    #[test]
    fn height_is_measured_in_metres_whatever_the_scale() {
        let node = DAffine3::from_scale_rotation_translation(
            DVec3::new(3.0, 5.0, 7.0),
            glam::DQuat::from_rotation_z(0.5),
            DVec3::new(1.0, 2.0, 3.0),
        );
        let falloff = Falloff::new(node, -1.0, 10.0).expect("a real space");
        let up = node.transform_vector3(DVec3::Y).normalize();
        let origin = node.transform_point3(DVec3::new(0.3, -1.0, 0.8));
        let climb = falloff.along(&Ray { origin, direction: up });
        assert!(climb.start.abs() < 1e-15 && (climb.per_m - 0.1).abs() < 1e-15, "{climb:?}");
    }
}
