//! A frozen camera. In go film positions and points of the lens, out come rays. Invariant: the centre of the
//! lens is the origin of relative space.

use crate::math::{Ray, disc_from_square};
use crate::scene::{Camera, Clip, Lens};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::f64::consts::TAU;
use std::ops::Range;

/// View of a camera: its place, lens and clipping planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera in world space, metres.
    pub eye: DVec3,
    right: DVec3,
    up: DVec3,
    backward: DVec3,
    /// Half extents of the picture, and its centre, at distance 1; for parallel rays in any plane.
    half: DVec2,
    middle: DVec2,
    /// Whether its rays are parallel.
    pub is_orthographic: bool,
    /// Radius of the lens, metres; 0 for a pinhole.
    lens_radius_m: f64,
    /// Distance of the plane in focus, metres.
    pub focus_distance_m: f64,
    /// Number of straight blades of the aperture; 0 for a round one.
    blades: u32,
    /// Clipping planes, between which surfaces are visible.
    clip: Clip,
}

impl View {
    /// Freezes `camera`; `aspect` is width / height.
    pub fn new(camera: &Camera, world_from_camera: DAffine3, aspect: f64, time_s: f64) -> Self {
        let (half, middle) = camera.picture(aspect, time_s);
        // Scale and shear of the node do not reach the picture: orthonormalise, keeping -Z exact.
        let axes = world_from_camera.matrix3;
        let backward = axes.z_axis.try_normalize().unwrap_or(DVec3::Z);
        let right =
            axes.y_axis.cross(backward).try_normalize().unwrap_or_else(|| backward.any_orthonormal_vector());
        // A mirrored camera node renders a mirrored picture.
        let right = right * if right.dot(axes.x_axis) < 0.0 { -1.0 } else { 1.0 };
        let up = backward.cross(right) * backward.cross(right).dot(axes.y_axis).signum();
        let is_orthographic = matches!(camera.lens, Lens::Orthographic { .. });
        let aperture = camera.aperture.as_ref().filter(|_| !is_orthographic);
        // A pinhole has everything in focus; infinity is as good as any distance.
        let focus_distance_m =
            aperture.map_or(f64::INFINITY, |aperture| aperture.focus_distance_m.at(time_s));
        let lens_radius_m = aperture.map_or(0.0, |aperture| {
            let focal_length_m = 0.5 * aperture.sensor_width_m / half.x;
            0.5 * focal_length_m / aperture.f_stop.at(time_s)
        });
        Self {
            eye: world_from_camera.translation,
            right,
            up,
            backward,
            half,
            middle,
            is_orthographic,
            lens_radius_m,
            focus_distance_m,
            blades: aperture.map_or(0, |aperture| aperture.blades),
            clip: camera.clip,
        }
    }

    /// A view along -Z from a place in the world, without a camera.
    pub(super) fn at(eye: DVec3) -> Self {
        Self {
            eye,
            right: DVec3::X,
            up: DVec3::Y,
            backward: DVec3::Z,
            half: DVec2::ONE,
            middle: DVec2::ZERO,
            is_orthographic: false,
            lens_radius_m: 0.0,
            focus_distance_m: f64::INFINITY,
            blades: 0,
            clip: Clip::NONE,
        }
    }

    /// The view for surfaces in a box of relative space: without clipping planes if these hide none of them.
    pub fn of_surfaces(mut self, bounds: Option<(DVec3, DVec3)>) -> Self {
        let hides = |(low, high): (DVec3, DVec3)| {
            let (near_low, near_high) = self.box_before_clip_start();
            let is_before_start = near_low.cmple(high).all() && low.cmple(near_high).all();
            // The farthest corner in the view direction.
            let farthest = DVec3::select(self.backward.cmplt(DVec3::ZERO), high, low);
            is_before_start || self.depth(farthest) > self.clip.end_m
        };
        if !bounds.is_some_and(hides) {
            self.clip = Clip::NONE;
        }
        self
    }

    /// Corners of a box around the space in view before the near plane.
    fn box_before_clip_start(&self) -> (DVec3, DVec3) {
        let mut corners = Vec::with_capacity(8);
        for side in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
            let side = DVec2::from(side);
            let at_lens = self.lens_radius_m * side;
            let place = self.middle + side * self.half;
            let [start, end] = match self.is_orthographic {
                true => [place; 2],
                false => [at_lens, place * self.clip.start_m + at_lens],
            };
            let point =
                |place: DVec2, depth: f64| place.x * self.right + place.y * self.up - depth * self.backward;
            corners.extend([point(start, 0.0), point(end, self.clip.start_m)]);
        }
        let fold = |f: fn(DVec3, DVec3) -> DVec3, from| corners.iter().copied().fold(from, f);
        (fold(DVec3::min, DVec3::INFINITY), fold(DVec3::max, DVec3::NEG_INFINITY))
    }

    /// Clipping planes, between which surfaces are visible.
    pub fn clip(&self) -> Clip {
        self.clip
    }

    /// Range of a camera ray, metres, on which surfaces are visible.
    pub fn shown_along(&self, ray: &Ray) -> Range<f64> {
        if self.clip == Clip::NONE {
            return 0.0..f64::INFINITY;
        }
        let depth_per_m = self.depth(ray.direction);
        self.clip.start_m / depth_per_m..self.clip.end_m / depth_per_m
    }

    /// The ray from the centre of the lens through a film position: `(0, 0)` is the top left corner, `(1, 1)`
    /// the bottom right one.
    pub fn ray(&self, film_x: f64, film_y: f64) -> Ray {
        self.ray_from(DVec2::ZERO, film_x, film_y)
    }

    /// Ray from a point of the lens, given to the right and up from its centre, metres.
    pub fn ray_from(&self, lens_point: DVec2, film_x: f64, film_y: f64) -> Ray {
        let place = self.middle + DVec2::new(2.0 * film_x - 1.0, 1.0 - 2.0 * film_y) * self.half;
        let in_plane = |point: DVec2| point.x * self.right + point.y * self.up;
        if self.is_orthographic {
            return Ray { origin: in_plane(place), direction: -self.backward };
        }
        // All rays of a film position meet in the plane in focus.
        let place = place - lens_point / self.focus_distance_m;
        let direction = (in_plane(place) - self.backward).normalize();
        Ray { origin: in_plane(lens_point), direction }
    }

    /// Film position, as in [`View::ray`], of a point of relative space seen from the centre of the lens,
    /// also beyond the picture; `None` if it is not in front of the camera.
    pub fn film_place(&self, point: DVec3) -> Option<DVec2> {
        let across = DVec2::new(point.dot(self.right), point.dot(self.up));
        if self.is_orthographic {
            return Some(self.film_of(across));
        }
        let depth = self.depth(point);
        (depth > 0.0).then(|| self.film_of(across / depth))
    }

    /// Film position of a direction, for objects at infinity. `None` for parallel rays, which see it
    /// everywhere.
    pub fn film_place_of_direction(&self, direction: DVec3) -> Option<DVec2> {
        if self.is_orthographic { None } else { self.film_place(direction) }
    }

    fn film_of(&self, place: DVec2) -> DVec2 {
        let DVec2 { x, y } = (place - self.middle) / self.half;
        0.5 * DVec2::new(1.0 + x, 1.0 - y)
    }

    /// Whether it has a lens rather than a pinhole.
    pub fn has_lens(&self) -> bool {
        self.lens_radius_m > 0.0
    }

    /// The point of the lens that two numbers in `[0, 1)` sample, metres; uniform over the aperture.
    pub fn lens_point(&self, [u, v]: [f64; 2]) -> DVec2 {
        if self.blades == 0 {
            return self.lens_radius_m * disc_from_square(DVec2::new(u, v));
        }
        // A regular polygon consists of equal triangles around its centre (Pharr et al., PBR, section A.5.4:
        // uniform over a triangle with the square root for its first coordinate).
        let scaled = u * f64::from(self.blades);
        let corner = |number: f64| DVec2::from_angle(TAU * number / f64::from(self.blades));
        let (first, within) = (scaled.floor(), scaled.fract());
        let outwards = within.sqrt();
        self.lens_radius_m * outwards * corner(first).lerp(corner(first + 1.0), v)
    }

    /// Unit vectors to the right, up and forward.
    pub fn axes(&self) -> (DVec3, DVec3, DVec3) {
        (self.right, self.up, -self.backward)
    }

    /// Half width and height of the picture, at distance 1; for parallel rays in any plane.
    pub fn half_extents(&self) -> DVec2 {
        self.half
    }

    /// The picture's centre in the same plane, to the right and up from the view axis.
    pub fn middle(&self) -> DVec2 {
        self.middle
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
    use crate::math::Sampler;
    use crate::scene::{Aperture, Track};
    use glam::DQuat;

    fn view(world_from_camera: DAffine3) -> View {
        let lens = Lens::Perspective { fov_y: Track::from(std::f64::consts::FRAC_PI_2) };
        let aperture = Aperture {
            f_stop: Track::from(2.0),
            sensor_width_m: 0.036,
            focus_distance_m: Track::from(3.0),
            blades: 6,
        };
        let camera = Camera {
            name: String::new(),
            node: 0,
            lens,
            shift: DVec2::ZERO,
            aperture: Some(aperture),
            clip: Clip::NONE,
        };
        View::new(&camera, world_from_camera, 2.0, 0.0)
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

    /// Projecting a ray of a film position gives that position again.
    #[test]
    fn rays_and_projection_are_inverses() {
        let lenses = [
            Lens::Perspective { fov_y: Track::from(0.7) },
            Lens::Orthographic { height_m: Track::from(3.0) },
        ];
        for lens in lenses {
            for aspect in [0.5, 2.0] {
                let shift = DVec2::new(0.15, -0.1);
                let camera = Camera {
                    name: String::new(),
                    node: 0,
                    lens: lens.clone(),
                    shift,
                    aperture: None,
                    clip: Clip::NONE,
                };
                let view = View::new(&camera, DAffine3::IDENTITY, aspect, 0.0);
                let projection = camera.projection(aspect, 0.0);
                for film in [DVec2::ZERO, DVec2::new(0.2, 0.9), DVec2::ONE] {
                    let ray = view.ray(film.x, film.y);
                    let clip = projection * ray.at(2.5).extend(1.0);
                    let ndc = clip.truncate().truncate() / clip.w;
                    let expected = DVec2::new(2.0 * film.x - 1.0, 1.0 - 2.0 * film.y);
                    assert!(ndc.distance(expected) < 1e-14, "{ndc} is not {expected}");
                    assert!((clip.z - view.depth(ray.at(2.5))).abs() < 1e-14);
                }
                assert!(view.is_orthographic == matches!(lens, Lens::Orthographic { .. }));
            }
        }
    }

    #[test]
    fn parallel_rays_start_in_the_plane_of_the_camera() {
        let lens = Lens::Orthographic { height_m: Track::from(3.0) };
        let camera = Camera {
            name: String::new(),
            node: 0,
            lens,
            shift: DVec2::ZERO,
            aperture: None,
            clip: Clip::NONE,
        };
        let view = View::new(&camera, DAffine3::IDENTITY, 2.0, 0.0);
        let ray = view.ray(1.0, 0.0);
        assert_eq!((ray.origin, ray.direction), (DVec3::new(3.0, 1.5, 0.0), DVec3::NEG_Z));
    }

    #[test]
    fn rays_of_a_film_position_meet_in_the_plane_in_focus() {
        let view = view(DAffine3::IDENTITY);
        // A half width of 2 at distance 1 makes 36 mm a focal length of 9 mm, f/2 a radius of 2.25 mm.
        let edge = view.lens_point([0.999_999, 0.0]);
        assert!((edge.length() - 0.002_25).abs() < 1e-8, "{edge}");
        let (middle, edge) = (view.ray(0.3, 0.2), view.ray_from(edge, 0.3, 0.2));
        let in_focus = |ray: Ray| ray.at(-3.0 / ray.direction.z);
        let (a, b) = (in_focus(middle), in_focus(edge));
        assert!((a.z + 3.0).abs() < 1e-12 && (b.z + 3.0).abs() < 1e-12);
        assert!((a - b - (middle.origin - edge.origin)).length() > 1e-3 && a.distance(b) < 1e-12);
    }

    /// A hexagon's second moment is 5/24 of its squared side.
    #[test]
    fn lens_points_fill_the_polygon_evenly() {
        let view = view(DAffine3::IDENTITY);
        let (count, mut mean, mut square) = (1 << 14, DVec2::ZERO, 0.0);
        for sample in 0..count {
            let point = view.lens_point(Sampler::new(1, 0, 0, sample).next_2d().into()) / 0.002_25;
            mean += point / f64::from(count);
            square += point.x * point.x / f64::from(count);
        }
        assert!(mean.length() < 1e-3 && (square - 5.0 / 24.0).abs() < 1e-3, "{mean} {square}");
    }

    #[test]
    fn a_film_place_is_where_its_ray_goes() {
        let turned = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.4), DVec3::X);
        let view = view(turned);
        for (x, y) in [(0.5, 0.5), (0.1, 0.8), (1.3, -0.2)] {
            let ray = view.ray(x, y);
            let back = view.film_place(ray.at(7.0)).expect("it lies before the camera");
            assert!(back.distance(DVec2::new(x, y)) < 1e-12, "{back}");
            assert!(view.film_place(ray.at(-7.0)).is_none());
        }
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
