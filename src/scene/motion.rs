//! Motion of a node in its parent's space. In goes a time, out comes a transform. Invariant: a motion is a
//! pure function of time.

use super::Track;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Transform of a node at any time.
#[derive(Clone, Debug)]
pub enum Motion {
    /// Constant. Any affine map, shear and mirroring included.
    Still(DAffine3),
    /// Translation, rotation and scale, with keys of their own.
    Keyed {
        /// Metres.
        translation: Track<DVec3>,
        /// Rotation, applied after the scale.
        rotation: Rotation,
        /// Scale factors; may be negative or zero.
        scale: Track<DVec3>,
    },
    /// Aimed: at `position`, with -Z towards `target` and +Y as near to `up` as possible.
    Aimed {
        /// Metres.
        position: Track<DVec3>,
        /// Point that it looks at, in the space of `position`.
        target: Track<DVec3>,
        /// Up vector of any length; if it is 0 or along the view, the side direction is arbitrary.
        up: Track<DVec3>,
    },
}

/// Keyed rotation.
#[derive(Clone, Debug)]
pub enum Rotation {
    /// Interpolated along the shortest arc.
    Quaternion(Track<DQuat>),
    /// Angles in radians about x, then y, then z (Blender's XYZ order), so that more than
    /// half a turn can be keyed.
    EulerXyz(Track<DVec3>),
}

impl Motion {
    /// Identity, for nodes that only group.
    pub const STILL: Self = Self::Still(DAffine3::IDENTITY);

    /// Transform to the parent's space at `time_s`.
    pub fn parent_from_node(&self, time_s: f64) -> DAffine3 {
        match self {
            Self::Still(parent_from_node) => *parent_from_node,
            Self::Keyed { translation, rotation, scale } => DAffine3::from_scale_rotation_translation(
                scale.at(time_s),
                rotation.at(time_s),
                translation.at(time_s),
            ),
            Self::Aimed { position, target, up } => {
                aimed(position.at(time_s), target.at(time_s), up.at(time_s))
            }
        }
    }
}

/// Translation and rotation, as far as they had more keys.
type Curves = (Option<Track<DVec3>>, Option<Track<DQuat>>);

impl Motion {
    /// Drops keys that no time in a span needs, see [`Track::keep_span`]. Returns the curves with all keys.
    pub(super) fn keep_span(&mut self, span_s: (f64, f64)) -> Option<Curves> {
        let Self::Keyed { translation, rotation: Rotation::Quaternion(rotation), .. } = self else {
            return None;
        };
        Some((translation.keep_span(span_s), rotation.keep_span(span_s)))
    }
}

impl Rotation {
    /// Rotation at `time_s`.
    pub fn at(&self, time_s: f64) -> DQuat {
        match self {
            Self::Quaternion(track) => track.at(time_s),
            Self::EulerXyz(track) => {
                let angles = track.at(time_s);
                DQuat::from_rotation_z(angles.z)
                    * DQuat::from_rotation_y(angles.y)
                    * DQuat::from_rotation_x(angles.x)
            }
        }
    }
}

/// Transform to `position` whose -Z points to `target`.
fn aimed(position: DVec3, target: DVec3, up: DVec3) -> DAffine3 {
    let backward = (position - target).try_normalize().unwrap_or(DVec3::Z);
    // In a view along `up` the side direction is arbitrary.
    let right = up.cross(backward).try_normalize().unwrap_or_else(|| backward.any_orthonormal_vector());
    let matrix = DMat3::from_cols(right, backward.cross(right), backward);
    DAffine3::from_mat3_translation(matrix, position)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Extend, Key, Segment};
    use std::f64::consts::{FRAC_PI_2, TAU};

    #[test]
    fn aimed_motion_looks_at_its_target() {
        for target in [DVec3::new(1.0, 2.0, 3.0), DVec3::Y * 5.0, DVec3::NEG_Y * 5.0, DVec3::X] {
            let position = DVec3::new(0.0, 1.0, 0.0);
            let aim = Motion::Aimed { position: position.into(), target: target.into(), up: DVec3::Y.into() };
            let parent_from_node = aim.parent_from_node(0.0);
            let forward = parent_from_node.transform_vector3(DVec3::NEG_Z);
            assert!((forward - (target - position).normalize()).length() < 1e-12);
            assert!((parent_from_node.matrix3.determinant() - 1.0).abs() < 1e-12);
            assert!(parent_from_node.matrix3.y_axis.y >= -1e-12, "upside down towards {target}");
        }
    }

    #[test]
    fn euler_angles_turn_about_x_first_and_may_exceed_half_a_turn() {
        let angles = Rotation::EulerXyz(Track::from(DVec3::new(FRAC_PI_2, 0.0, FRAC_PI_2 + TAU)));
        assert!((angles.at(0.0) * DVec3::Y - DVec3::Z).length() < 1e-12);
        assert!((angles.at(0.0) * DVec3::X - DVec3::Y).length() < 1e-12);
    }

    #[test]
    fn only_motions_that_stay_put_are_still() {
        let keyed = |scale: Track<DVec3>| Motion::Keyed {
            translation: DVec3::ZERO.into(),
            rotation: Rotation::Quaternion(DQuat::IDENTITY.into()),
            scale,
        };
        assert!(Motion::STILL.is_still());
        assert!(keyed(DVec3::ONE.into()).is_still());
        let keys =
            [0.0, 1.0].map(|time_s| Key { time_s, value: DVec3::splat(time_s), to_next: Segment::Linear });
        let grows = Track::new(keys.to_vec(), Extend::Hold).expect("keys in order");
        assert!(!keyed(grows).is_still());
    }
}
