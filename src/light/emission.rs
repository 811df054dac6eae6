//! Angular distribution of a light without extent: its share of the intensity by direction. In go directions
//! and rays, out come shares, and the range of a ray that the light reaches. Invariant: between the crossings
//! returned here the share along a ray is either 0 throughout, or smooth.

use crate::math::Ray;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, TAU};

/// Share of the maximum intensity by direction.
#[derive(Clone, Copy, Debug)]
pub enum Emission {
    /// Isotropic.
    Even,
    /// Within a soft-edged cone.
    Spot(Cone),
    /// One side of a flat surface of uniform radiance: the cosine of the angle to its normal (Lambert).
    Flat {
        /// Unit vector towards the emitting side.
        normal: DVec3,
    },
    /// As `Flat`, behind a grid as of a soft box: its slats block more light farther off the normal, and all
    /// of it beyond the outer cone.
    Gridded(Cone),
}

/// Cosine below which a cone counts as a plane: its square is lost beside 1.
const FLAT: f64 = 1e-8;

/// Soft-edged cone of a spot.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// Unit vector along the beam.
    pub axis: DVec3,
    /// Cosine of the angle beyond which there is no light.
    pub cos_outer: f64,
    /// Cosine of the angle within which the share is 1.
    pub cos_inner: f64,
}

impl Emission {
    /// Share of the intensity along a unit vector.
    pub fn share(&self, away: DVec3) -> f64 {
        match self {
            Self::Even => 1.0,
            Self::Spot(cone) => cone.falloff(away.dot(cone.axis)),
            Self::Flat { normal } => away.dot(*normal).max(0.0),
            Self::Gridded(cone) => cone.gridded(away.dot(cone.axis)),
        }
    }

    /// Unit vector that two uniform numbers sample among the lit directions: uniformly, or by the cosine of a
    /// flat surface.
    pub fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let (axis, along) = match self {
            Self::Even => (DVec3::Y, 1.0 - 2.0 * u),
            Self::Spot(cone) | Self::Gridded(cone) => (cone.axis, 1.0 - (1.0 - cone.cos_outer) * u),
            Self::Flat { normal } => (*normal, (1.0 - u).sqrt()),
        };
        let (right, up) = axis.any_orthonormal_pair();
        let (sin, cos) = (TAU * v).sin_cos();
        along * axis + (1.0 - along * along).max(0.0).sqrt() * (cos * right + sin * up)
    }

    /// Probability density of [`Emission::sample`], 1/sr.
    pub fn pdf(&self, away: DVec3) -> f64 {
        match self {
            Self::Even => 1.0 / (2.0 * TAU),
            Self::Spot(cone) | Self::Gridded(cone) => {
                let is_within = away.dot(cone.axis) >= cone.cos_outer;
                if is_within { 1.0 / (TAU * (1.0 - cone.cos_outer)) } else { 0.0 }
            }
            Self::Flat { normal } => away.dot(*normal).max(0.0) * FRAC_1_PI,
        }
    }

    /// Whether light reaches a direction, given by a vector of any length.
    pub fn reaches(&self, away: DVec3) -> bool {
        match self {
            Self::Even => true,
            Self::Spot(cone) | Self::Gridded(cone) => away.dot(cone.axis) >= cone.cos_outer * away.length(),
            Self::Flat { normal } => away.dot(*normal) > 0.0,
        }
    }

    /// Every `t` at which a ray may enter or leave the range of the light at `position`, in order.
    pub fn borders(&self, ray: &Ray, position: DVec3) -> [Option<f64>; 2] {
        match self {
            Self::Even => [None, None],
            Self::Spot(cone) | Self::Gridded(cone) => cone.crossings(cone.cos_outer, ray, position),
            Self::Flat { normal } => {
                let t = (position - ray.origin).dot(*normal) / ray.direction.dot(*normal);
                [t.is_finite().then_some(t), None]
            }
        }
    }

    /// Every `t` within the lit range at which the share of the light is not smooth, in order.
    pub fn kinks(&self, ray: &Ray, position: DVec3) -> [Option<f64>; 2] {
        match self {
            Self::Even | Self::Flat { .. } => [None, None],
            Self::Spot(cone) => cone.crossings(cone.cos_inner, ray, position),
            Self::Gridded(cone) => [cone.nearest_to_axis(ray, position), None],
        }
    }
}

impl Cone {
    /// Share of the intensity at an angle from the axis, as in Cycles: `smoothstep((cos - cos_outer) / ((1 -
    /// cos_outer) * blend))`.
    pub fn falloff(&self, cos_angle: f64) -> f64 {
        let width = self.cos_inner - self.cos_outer;
        if width <= 0.0 {
            return if cos_angle >= self.cos_outer { 1.0 } else { 0.0 };
        }
        let x = ((cos_angle - self.cos_outer) / width).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }

    /// Share of a flat light's intensity at an angle `a` from the axis behind a grid, as in Cycles: `cos a (1
    /// - tan a / tan a_outer) = sin(a_outer - a) / sin a_outer`.
    fn gridded(&self, cos_angle: f64) -> f64 {
        let sine = |cos: f64| (1.0 - cos * cos).max(0.0).sqrt();
        (cos_angle - sine(cos_angle) * self.cos_outer / sine(self.cos_outer)).max(0.0)
    }

    /// Point of a ray nearest to the axis, where angles from it change fastest.
    fn nearest_to_axis(&self, ray: &Ray, apex: DVec3) -> Option<f64> {
        let (off, growth) = ((ray.origin - apex).cross(self.axis), ray.direction.cross(self.axis));
        let t = -off.dot(growth) / growth.length_squared();
        t.is_finite().then_some(t)
    }

    /// Crossings of a ray with the double cone of an angle about the axis, in order.
    ///
    /// With `x(t) = ray.at(t) - apex` its surface is `(x . axis)^2 = cos^2 |x|^2`, a quadratic in `t`.
    fn crossings(&self, cos: f64, ray: &Ray, apex: DVec3) -> [Option<f64>; 2] {
        let x = ray.origin - apex;
        let (da, xa) = (ray.direction.dot(self.axis), x.dot(self.axis));
        if cos < FLAT {
            return [(-xa / da).is_finite().then_some(-xa / da), None];
        }
        let a = da * da - cos * cos;
        let half_b = da * xa - cos * cos * x.dot(ray.direction);
        let c = xa * xa - cos * cos * x.length_squared();
        // half_b^2 - a c without its factor cos^2, so that nearly flat cones keep their digits.
        let across = (da * x - xa * ray.direction).length_squared();
        let discriminant = cos * cos * (across - cos * cos * x.cross(ray.direction).length_squared());
        if discriminant <= 0.0 {
            return [None, None];
        }
        // The stable form of the quadratic's roots (Press et al., Numerical Recipes, section 5.6).
        let q = -(half_b + discriminant.sqrt().copysign(half_b));
        let (first, second) = (q / a, c / q);
        let finite = |t: f64| t.is_finite().then_some(t);
        if first < second { [finite(first), finite(second)] } else { [finite(second), finite(first)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn falloff_is_a_smoothstep_between_the_cones() {
        let cone = Cone { axis: DVec3::NEG_Z, cos_outer: 0.5, cos_inner: 0.7 };
        assert_eq!(cone.falloff(0.4), 0.0);
        assert_eq!(cone.falloff(0.9), 1.0);
        assert!((cone.falloff(0.6) - 0.5).abs() < 1e-15);
    }

    /// Its cone is nearly a plane, which the ray crosses: found by a random test, when the quadratic's
    /// discriminant lost its digits.
    #[test]
    fn a_nearly_flat_cone_has_a_border() {
        let axis = DVec3::new(0.08563129501431122, -0.10191341377931044, 0.9911008714586116).normalize();
        let cone = Cone { axis, cos_outer: (FRAC_PI_2 - 1e-7).cos(), cos_inner: 1.0 };
        let direction = DVec3::new(0.7277373807464518, -0.10629953267148119, 0.9131622180405322).normalize();
        let origin = DVec3::new(1.57252818790137, -0.04578456021813493, 1.5835657394855875);
        let borders = Emission::Spot(cone).borders(&Ray { origin, direction }, DVec3::ZERO);
        let plane = -origin.dot(axis) / direction.dot(axis);
        assert!(borders.iter().flatten().all(|border| (border - plane).abs() < 1e-5), "{borders:?} {plane}");
        assert!(borders.iter().flatten().count() > 0);
    }

    proptest! {
        /// Between two borders either all of the ray is reached, or none.
        #[test]
        fn light_begins_and_ends_at_the_borders(
            x in prop::array::uniform3(-2.0..2.0_f64), d in prop::array::uniform3(-1.0..1.0_f64),
            n in prop::array::uniform3(-1.0..1.0_f64),
            angle in prop_oneof![4 => 0.05..1.5_f64, 1 => Just(FRAC_PI_2), 1 => Just(FRAC_PI_2 - 1e-7)], u in 0.001..0.999_f64, v in 0.001..0.999_f64
        ) {
            let (Some(direction), Some(axis)) = (DVec3::from(d).try_normalize(), DVec3::from(n).try_normalize()) else {
                return Ok(());
            };
            let ray = Ray { origin: DVec3::from(x), direction };
            let cone = Cone { axis, cos_outer: angle.cos(), cos_inner: 1.0 };
            let coned = [Emission::Spot(cone), Emission::Gridded(cone)];
            for emission in coned.into_iter().chain([Emission::Flat { normal: axis }, Emission::Even]) {
                let mut start = -50.0;
                for end in emission.borders(&ray, DVec3::ZERO).into_iter().flatten().chain([50.0]) {
                    let end = end.clamp(start, 50.0);
                    if end - start > 1e-6 {
                        let reached = |u: f64| {
                            let away = ray.at(start + u * (end - start));
                            (emission.reaches(away), emission.share(away.normalize()) > 0.0)
                        };
                        prop_assert_eq!(reached(u).0, reached(v).0, "{:?} from {} to {}", emission, start, end);
                        prop_assert_eq!(reached(u).0, reached(u).1);
                    }
                    start = end;
                }
            }
        }
    }
}
