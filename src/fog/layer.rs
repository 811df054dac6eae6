//! Fog that differs with height alone. In goes a bank, out come its up direction and its scale height, or
//! a slab's height. Invariant: a slab counts only where its sides are too far to matter.

use super::FogBank;
use super::bank::Density;
use glam::{DAffine3, DMat3, DVec3};

/// Minimum distance from the middle of a slab to its sides, in heights. However thin the fog is: it may be
/// keyed, and light must not change as it goes over into layers.
const FAR: f64 = 10.0;
/// Maximum distance from a side of a slab to the end of the ground, as a share of the distance to the middle.
const BESIDE: f64 = 0.1;
/// Maximum gap between the ground and a slab, as a share of its half height.
const WITHIN: f64 = 1e-6;

impl FogBank {
    /// Direction in which fog without sides thins out, a unit vector, and its scale height; of a slab, its
    /// height. In metres.
    pub fn layer(&self) -> Option<(DVec3, f64)> {
        match &self.density {
            Density::Thinning(falloff) if !self.is_bounded() => Some(falloff.up()),
            Density::Even if !self.is_bounded() => {
                Some((DVec3::Y, 2.0 / self.cube_from_relative.matrix3.y_axis.y.abs()))
            }
            Density::Even | Density::Thinning(_) | Density::Voxels(_) => None,
        }
    }

    /// Bounds of even fog in a box along the axes, in relative space.
    pub fn level_box(&self) -> Option<(DVec3, DVec3)> {
        let axes = self.cube_from_relative.matrix3;
        let along = DVec3::new(axes.x_axis.x, axes.y_axis.y, axes.z_axis.z);
        self.bounds().filter(|_| self.is_even() && axes == DMat3::from_diagonal(along))
    }

    /// A level slab of even fog without its sides, if these are far and stay there, and the ground ends with
    /// them and begins with the fog. `ground` has the bounds of what faces up and is so wide, in relative
    /// space.
    pub(super) fn without_sides(&self, ground: &dyn Fn(f64) -> Option<(DVec3, DVec3)>) -> Option<Self> {
        let (low, high) = self.level_box().filter(|_| self.stays)?;
        let half = 0.5 * (high - low);
        let is_flat = half.x.min(half.z) > FAR * 2.0 * half.y;
        // What drifts past its sides is not ground.
        let ground = if is_flat { ground(half.x.min(half.z))? } else { return None };
        if low.y > ground.0.y + WITHIN * half.y {
            return None;
        }
        let gaps = [ground.0 - low, high - ground.1];
        let is_near = |gap: DVec3| gap.abs().cmple(BESIDE * half);
        let DAffine3 { matrix3, translation } = self.cube_from_relative;
        let along = DVec3::Y * matrix3.y_axis.y;
        let cube_from_relative =
            DAffine3 { matrix3: DMat3::from_diagonal(along), translation: translation * DVec3::Y };
        let end_alike = gaps.into_iter().map(is_near).all(|sides| sides.test(0) && sides.test(2));
        end_alike.then(|| Self { cube_from_relative, ..self.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slab_is_one_however_thin_its_fog_is() {
        let (low, high) = (DVec3::new(-15.0, 0.0, -15.0), DVec3::new(15.0, 0.8, 15.0));
        let ground = |_: f64| Some((low, high * DVec3::new(1.0, 0.0, 1.0)));
        for extinction_per_m in [1e-3, 0.3, 5.0] {
            let slab = FogBank::between(low, high, extinction_per_m);
            assert!(slab.without_sides(&ground).is_some(), "{extinction_per_m}");
        }
        let moving = FogBank { stays: false, ..FogBank::between(low, high, 1.0) };
        assert!(moving.without_sides(&ground).is_none(), "its sides may not stay far");
    }
}
