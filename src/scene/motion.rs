//! How a node moves in its parent's space. Invariant: a motion is a pure function of time.

use super::Track;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// A node's transform at any time.
#[derive(Clone, Debug)]
pub enum Motion {
    /// Never moves. Any affine map, shear and mirroring included.
    Still(DAffine3),
    /// Translation, rotation and scale, each keyed on its own.
    Keyed {
        /// Metres.
        translation: Track<DVec3>,
        /// Applied after the scale.
        rotation: Rotation,
        /// Factors; may be negative or zero.
        scale: Track<DVec3>,
    },
    /// Stands at `position` with -Z towards `target` and +Y as near to `up` as that allows.
    Aimed {
        /// Metres.
        position: Track<DVec3>,
        /// The point looked at, in the same space as `position`.
        target: Track<DVec3>,
        /// Of any length; if it is 0, or along the view, any sideways direction will do.
        up: Track<DVec3>,
    },
    /// A leaf that falls along a parametric path.
    Falling(FallingPath),
}

/// A keyed rotation.
#[derive(Clone, Debug)]
pub enum Rotation {
    /// Interpolated along the shortest arc.
    Quaternion(Track<DQuat>),
    /// Angles in radians about x, then y, then z (Blender's XYZ order), so that more than
    /// half a turn can be keyed.
    EulerXyz(Track<DVec3>),
}

/// A leaf's simple way down: steady descent, a swing from side to side and a turn about an axis.
///
/// The leaf rests once it has come down to `ground_y`.
#[derive(Clone, Debug)]
pub struct FallingPath {
    /// Where it is at time 0, were it not for the swing, metres.
    pub start: DVec3,
    /// Mean velocity, m/s; `y` is negative.
    pub velocity: DVec3,
    /// Half width and direction of the swing, metres, horizontal.
    pub swing: DVec3,
    /// Swings a second, Hz.
    pub swing_hz: f64,
    /// Phase of swing and turn at time 0, radians.
    pub phase: f64,
    /// Attitude at time 0.
    pub attitude: DQuat,
    /// Unit axis of the turn, in the parent's space.
    pub spin_axis: DVec3,
    /// Turn rate, rad/s.
    pub spin_rad_per_s: f64,
    /// Uniform scale, > 0.
    pub scale: f64,
    /// Height at which the leaf comes to rest, metres.
    pub ground_y: f64,
}

impl Motion {
    /// The identity, for nodes that only group.
    pub const STILL: Self = Self::Still(DAffine3::IDENTITY);

    /// Parent from node at `time_s`.
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
            Self::Falling(path) => path.parent_from_leaf(time_s),
        }
    }
}

impl Rotation {
    /// The rotation at `time_s`.
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

impl FallingPath {
    /// Parent from leaf at `time_s`.
    pub fn parent_from_leaf(&self, time_s: f64) -> DAffine3 {
        // Everything follows the time in the air, so a leaf that has landed lies still.
        let time_in_air_s = if self.velocity.y < 0.0 {
            time_s.min((self.ground_y - self.start.y) / self.velocity.y)
        } else {
            time_s
        };
        let swing_angle = std::f64::consts::TAU * self.swing_hz * time_in_air_s + self.phase;
        let position = self.start + self.velocity * time_in_air_s + self.swing * swing_angle.sin();
        let turn = DQuat::from_axis_angle(self.spin_axis, self.spin_rad_per_s * time_in_air_s);
        DAffine3::from_scale_rotation_translation(DVec3::splat(self.scale), turn * self.attitude, position)
    }
}

/// The frame at `position` whose -Z points to `target`.
fn aimed(position: DVec3, target: DVec3, up: DVec3) -> DAffine3 {
    let backward = (position - target).try_normalize().unwrap_or(DVec3::Z);
    // Looking straight along `up`, any sideways direction will do.
    let right = up.cross(backward).try_normalize().unwrap_or_else(|| backward.any_orthonormal_vector());
    let matrix = DMat3::from_cols(right, backward.cross(right), backward);
    DAffine3::from_mat3_translation(matrix, position)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, TAU};

    fn falling() -> FallingPath {
        FallingPath {
            start: DVec3::new(0.0, 3.0, 0.0),
            velocity: DVec3::new(0.1, -1.0, 0.0),
            swing: DVec3::new(0.0, 0.0, 0.4),
            swing_hz: 0.5,
            phase: 0.3,
            attitude: DQuat::from_rotation_x(0.2),
            spin_axis: DVec3::Y,
            spin_rad_per_s: 2.0,
            scale: 0.05,
            ground_y: 0.01,
        }
    }

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
    fn leaf_lands_on_the_ground_and_lies_still() {
        let path = falling();
        let landed = path.parent_from_leaf(2.99);
        assert!((landed.translation.y - path.ground_y).abs() < 1e-12);
        assert_eq!(landed, path.parent_from_leaf(1000.0));
        assert!(path.parent_from_leaf(2.9).translation.y > path.ground_y);
    }

    #[test]
    fn leaf_falls_with_its_mean_velocity() {
        let path = falling();
        let period_s = 1.0 / path.swing_hz;
        let step = path.parent_from_leaf(0.5 + period_s).translation - path.parent_from_leaf(0.5).translation;
        assert!((step - path.velocity * period_s).length() < 1e-12);
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
        assert!(!Motion::Falling(falling()).is_still());
    }
}
