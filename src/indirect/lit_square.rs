//! Light without extent on a small square of a wall. In go a square and a light, out comes the mean
//! irradiance. Invariant: all light of an even or flat lamp that reaches its plane lands on some square,
//! however near.

use crate::color::Rgb;
use crate::light::{Emission, FrozenLight};
use glam::DVec3;

/// A part of a wall that is lit uniformly.
#[derive(Clone, Copy)]
pub(super) struct Square {
    /// Centre in relative space.
    pub(super) middle: DVec3,
    /// Vectors from its centre to the middles of two sides.
    pub(super) half: [DVec3; 2],
}

impl Square {
    /// Unit vector to a light, and the mean irradiance on the side of a normal, W/m^2. For a lamp it is the
    /// intensity over its solid angle, per area, at any distance.
    pub(super) fn lit(&self, light: &FrozenLight, normal: DVec3) -> (DVec3, Rgb) {
        let (to_light, distance, arriving) = light.arriving_at(self.middle);
        let irradiance = match light {
            FrozenLight::Sun { .. } => to_light.dot(normal).max(0.0) * arriving,
            FrozenLight::Point { .. } if to_light.dot(normal) <= 0.0 => Rgb::ZERO,
            FrozenLight::Point { position, intensity, emission: Emission::Flat { normal }, .. } => {
                *intensity * self.projected_solid_angle(*position, *normal) / self.area_m2()
            }
            FrozenLight::Point { position, .. } => {
                arriving * distance * distance * self.solid_angle(*position) / self.area_m2()
            }
        };
        (to_light, irradiance)
    }

    pub(super) fn area_m2(&self) -> f64 {
        4.0 * self.half[0].length() * self.half[1].length()
    }

    /// Vectors from a point to its corners, in order.
    fn corners(&self, from: DVec3) -> [DVec3; 4] {
        let [right, up] = self.half;
        [-right - up, right - up, right + up, up - right].map(|corner| self.middle + corner - from)
    }

    /// Solid angle of the square as seen from a point, sr.
    fn solid_angle(&self, from: DVec3) -> f64 {
        let [a, b, c, d] = self.corners(from).map(DVec3::normalize_or_zero);
        of_triangle(a, b, c) + of_triangle(a, c, d)
    }

    /// Integral of the cosine to a normal over the solid angle of the square, sr, as far as that lies before
    /// the point. It is the sum over edges of the angles that they subtend times cosines of their planes
    /// (Lambert 1760, "Photometria"; Arvo 1995, "Applications of irradiance tensors to the simulation of
    /// non-Lambertian phenomena").
    fn projected_solid_angle(&self, from: DVec3, normal: DVec3) -> f64 {
        let corners = self.corners(from);
        let mut before = Vec::with_capacity(5);
        for (number, &a) in corners.iter().enumerate() {
            let b = corners[(number + 1) % corners.len()];
            let [of_a, of_b] = [a, b].map(|corner| corner.dot(normal));
            if of_a > 0.0 {
                before.push(a);
            }
            if (of_a > 0.0) != (of_b > 0.0) {
                before.push(a + of_a / (of_a - of_b) * (b - a));
            }
        }
        let of_edge = |(a, b): (&DVec3, &DVec3)| {
            let across = a.cross(*b);
            across.length().atan2(a.dot(*b)) * across.normalize_or_zero().dot(normal)
        };
        let edges = before.iter().zip(before.iter().cycle().skip(1));
        0.5 * edges.map(of_edge).sum::<f64>().abs()
    }
}

/// Solid angle of a triangle, given unit vectors to its corners, sr (Van Oosterom & Strackee 1983, "The solid
/// angle of a plane triangle", equation 8).
fn of_triangle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::LampShape;
    use std::f64::consts::PI;

    fn lamp(position: DVec3, emission: Emission) -> FrozenLight {
        FrozenLight::Point { position, intensity: Rgb::splat(3.0), emission, shape: LampShape::NONE }
    }

    /// A lamp sends half of its light to a wide wall, however near it is; a far wall has that of a point
    /// light.
    #[test]
    fn a_lamp_lights_a_square_by_its_solid_angle() {
        let lit = |half_m: f64, height_m: f64| {
            let square = Square { middle: DVec3::ZERO, half: [half_m * DVec3::X, half_m * DVec3::Y] };
            square.lit(&lamp(height_m * DVec3::Z, Emission::Even), DVec3::Z).1.x
        };
        for height_m in [1e-9, 1e-3, 1e-2] {
            let power = 4.0 * 1e4 * lit(100.0, height_m);
            assert!((power / (3.0 * 2.0 * PI) - 1.0).abs() < 1e-3, "{height_m}: {power}");
        }
        assert!((lit(1e-3, 2.0) / (3.0 / 4.0) - 1.0).abs() < 1e-6);
        // A face of a cube around the lamp has a sixth of its light.
        assert!((4.0 * lit(1.0, 1.0) / (3.0 * 4.0 * PI / 6.0) - 1.0).abs() < 1e-12);
        assert_eq!(lit(1.0, -1.0), 0.0, "from behind");
    }

    /// Faces of a cube around it have all of its light, some of them in part, wherever it faces.
    #[test]
    fn a_flat_light_lights_the_squares_before_it() {
        for facing in [DVec3::Z, DVec3::new(0.3, -0.5, 0.8), DVec3::new(-0.7, 0.1, 0.2)] {
            let light = lamp(DVec3::ZERO, Emission::Flat { normal: facing.normalize() });
            let axes = [DVec3::X, DVec3::Y, DVec3::Z];
            let faces = axes.into_iter().flat_map(|axis| [axis, -axis]);
            let power: f64 = faces
                .map(|middle| {
                    let (right, up) = middle.any_orthonormal_pair();
                    4.0 * Square { middle, half: [right, up] }.lit(&light, -middle).1.x
                })
                .sum();
            assert!((power / (3.0 * PI) - 1.0).abs() < 1e-12, "{facing}: {power}");
        }
    }
}
