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
        /// Unit vector.
        up: DVec3,
    },
    /// A leaf that falls along a parametric path.
    Falling(FallingPath),
}

/// A keyed rotation.
#[derive(Clone, Debug)]
pub enum Rotation {
    /// Interpolated along the shortest arc.
    Quaternion(Track<DQuat>),
    /// Angles in radians about x, then y, then z (Blender's XYZ order), so that more than half a turn can be keyed.
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
            Self::Aimed { position, target, up } => aimed(position.at(time_s), target.at(time_s), *up),
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
