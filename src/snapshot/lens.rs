//! A frozen camera: film positions in, rays out. Invariant: rays start at the origin of relative space.

use crate::math::Ray;
use crate::scene::{Camera, Lens};
use glam::{DAffine3, DMat3, DVec2, DVec3};

/// Where the camera stands and what it sees.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The camera in world space, metres.
    pub eye: DVec3,
    right: DVec3,
    up: DVec3,
    backward: DVec3,
    /// Half extents of the picture at distance 1.
    half_width: f64,
    half_height: f64,
    /// Distance of the plane in focus, metres.
    focus_distance_m: f64,
}

impl View {
    /// Freezes `camera`; `aspect` is width / height.
    pub fn new(camera: &Camera, world_from_camera: DAffine3, aspect: f64, time_s: f64) -> Self {
        let Lens::Perspective { fov_y } = &camera.lens;
        let half_height = (0.5 * fov_y.at(time_s)).tan();
        // Scale and shear of the node do not reach the picture: orthonormalise, keeping -Z exact.
        let axes = world_from_camera.matrix3;
        let backward = axes.z_axis.try_normalize().unwrap_or(DVec3::Z);
        let right =
            axes.y_axis.cross(backward).try_normalize().unwrap_or_else(|| backward.any_orthonormal_vector());
        // A mirrored camera node shows a mirrored picture.
        let right = right * if right.dot(axes.x_axis) < 0.0 { -1.0 } else { 1.0 };
        let up = backward.cross(right) * backward.cross(right).dot(axes.y_axis).signum();
        Self {
            eye: world_from_camera.translation,
            right,
            up,
            backward,
            half_width: half_height * aspect,
            half_height,
            focus_distance_m: f64::INFINITY,
        }
    }

    /// The ray through a film position: `(0, 0)` is the top left corner, `(1, 1)` the bottom right one.
    pub fn ray(&self, film_x: f64, film_y: f64) -> Ray {
        let x = (2.0 * film_x - 1.0) * self.half_width;
        let y = (1.0 - 2.0 * film_y) * self.half_height;
        let direction = (x * self.right + y * self.up - self.backward).normalize();
        Ray { origin: DVec3::ZERO, direction }
    }

    /// Unit vectors to the right, up and forward.
    pub fn axes(&self) -> (DVec3, DVec3, DVec3) {
        (self.right, self.up, -self.backward)
    }

    /// Half width and height of the picture at distance 1.
    pub fn half_extents(&self) -> DVec2 {
        DVec2::new(self.half_width, self.half_height)
    }

    /// Distance of the plane that is in focus, metres; infinite without a lens.
    pub fn focus_distance_m(&self) -> f64 {
        self.focus_distance_m
    }

    /// Distance of a point of relative space along the view axis (planar Z), metres.
    pub fn depth(&self, point: DVec3) -> f64 {
        -point.dot(self.backward)
    }

    /// Camera from world (right, up, backward), for the frame's `worldToCamera`.
    pub fn camera_from_world(&self) -> DAffine3 {
        let axes = DMat3::from_cols(self.right, self.up, self.backward).transpose();
        DAffine3::from_mat3_translation(axes, -(axes * self.eye))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Track;
    use glam::DQuat;

    fn view(world_from_camera: DAffine3) -> View {
        let lens = Lens::Perspective { fov_y: Track::from(std::f64::consts::FRAC_PI_2) };
        View::new(&Camera { name: String::new(), node: 0, lens }, world_from_camera, 2.0, 0.0)
    }

    #[test]
    fn the_middle_looks_along_minus_z_and_the_top_edge_half_the_angle_up() {
        let view = view(DAffine3::IDENTITY);
        assert!(view.ray(0.5, 0.5).direction.distance(DVec3::NEG_Z) < 1e-15);
        let top = view.ray(0.5, 0.0).direction;
        assert!((top.y - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-15 && top.z < 0.0);
        let right = view.ray(1.0, 0.5).direction;
        assert!((right.x / -right.z - 2.0).abs() < 1e-14);
    }

    #[test]
    fn scale_of_the_node_does_not_change_the_picture() {
        let turn = DQuat::from_rotation_y(0.4);
        let plain = view(DAffine3::from_rotation_translation(turn, DVec3::X));
        let scaled =
            view(DAffine3::from_scale_rotation_translation(DVec3::new(3.0, 0.5, 7.0), turn, DVec3::X));
        assert!(plain.ray(0.1, 0.8).direction.distance(scaled.ray(0.1, 0.8).direction) < 1e-14);
    }

    #[test]
    fn camera_from_world_takes_the_eye_to_the_origin() {
        let world_from_camera =
            DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.3), DVec3::new(1.0, 2.0, 3.0));
        let matrix = view(world_from_camera).camera_from_world();
        assert!(matrix.abs_diff_eq(world_from_camera.inverse(), 1e-14));
    }
}
