//! Motion of a surface point in the picture, from a frame before to a frame after. In go a triangle and a
//! place on it, out come pixels. Invariant: pure; it builds no tree and traces no ray.
//!
//! The point is the same for any moment of the shutter at which it was seen: all samples of a still leaf
//! agree, and motion blur changes no vector.

use super::View;
use crate::scene::{Instance, Scene, Size};
use glam::{DAffine3, DVec2, DVec3, Vec3};

/// Number of moments, in order of time.
const MOMENTS: usize = 3;

/// Transforms and shapes of all instances, at three moments.
#[derive(Debug)]
pub struct MotionField {
    size: Size,
    moments: [Moment; MOMENTS],
}

#[derive(Debug)]
struct Moment {
    view: View,
    /// Transform of each of the scene's instances, and its vertices if it bends.
    shapes: Vec<(DAffine3, Option<Vec<Vec3>>)>,
}

impl MotionField {
    /// Motion field from the moments a frame before, at the frame and a frame after; for the other arguments
    /// see [`super::Snapshot::new`].
    pub fn new(scene: &Scene, camera: usize, size: Size, times_s: [f64; MOMENTS]) -> Self {
        let aspect = size.width as f64 / size.height as f64;
        let moments = times_s.map(|time_s| {
            let placements = scene.placements(time_s);
            let camera = &scene.cameras[camera];
            let shape = |instance: &Instance| {
                let (vertices, world_from_shape) = scene.vertices(instance, &placements, time_s);
                let bent = instance.deformation.is_some().then(|| vertices.into_owned());
                (world_from_shape, bent)
            };
            Moment {
                view: View::new(camera, placements[camera.node].world_from_node, aspect, time_s),
                shapes: scene.instances.iter().map(shape).collect(),
            }
        });
        Self { size, moments }
    }

    /// Motion of a point of an instance's triangle, with the `weights` of its three vertices.
    pub(super) fn of_point(
        &self,
        scene: &Scene,
        instance: usize,
        triangle: usize,
        weights: [f64; 3],
    ) -> [f64; 4] {
        let mesh = &scene.meshes[scene.instances[instance].mesh];
        let corners = mesh.triangles[triangle].vertices;
        self.vectors(|moment| {
            let (world_from_shape, bent) = &moment.shapes[instance];
            let vertices = bent.as_ref().unwrap_or(&mesh.positions);
            let corner = |number: usize| weights[number] * vertices[corners[number] as usize].as_dvec3();
            let point = world_from_shape.transform_point3((0..3).map(corner).sum());
            moment.view.film_place(point - moment.view.eye)
        })
    }

    /// Motion of objects at infinity in a direction.
    pub(super) fn of_direction(&self, direction: DVec3) -> [f64; 4] {
        self.vectors(|moment| moment.view.film_place_of_direction(direction))
    }

    /// Vectors as Blender has them: from the place now to the one before, and from the place after to the one
    /// now, in pixels to the right and up; 0 where the point is behind the camera.
    fn vectors(&self, film_place: impl Fn(&Moment) -> Option<DVec2>) -> [f64; 4] {
        let [before, now, after] = self.moments.each_ref().map(film_place);
        let pixels = DVec2::new(self.size.width as f64, -(self.size.height as f64));
        let between = |from: Option<DVec2>, to: Option<DVec2>| {
            from.zip(to).map_or(DVec2::ZERO, |(from, to)| (to - from) * pixels)
        };
        let (back, forth) = (between(now, before), between(after, now));
        [back.x, back.y, forth.x, forth.y]
    }
}
