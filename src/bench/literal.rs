//! The method that this renderer grew from, as its authors described it. Every pixel tests its ray against
//! every triangle. Every step of the image plane tests a shadow ray against every triangle again. In go some
//! pixels of a picture, out come their shafts and the time. Invariant: it uses no tree.
//! It has two advantages that its authors' version lacked. Shadow rays end at the first occluding triangle.
//! The intersection is Moeller & Trumbore's, which costs less than comparing areas.

use super::Stage;
use super::method::timed;
use crate::color::Rgb;
use crate::fog::exp_minus;
use crate::math::{Ray, Sampler};
use crate::snapshot::{FrozenLight, Luminaire, Snapshot};
use crate::transport::{MarchSteps, Scratch, Transport, VolumeMethod, radiance};
use glam::DVec3;

/// Measurement of a part of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Literal {
    /// Number of pixels rendered, evenly distributed over the picture.
    pub pixels: usize,
    /// Processor time of the whole picture at this rate, seconds.
    pub picture_s: f64,
    /// Root mean square difference of the shafts from those by the tree, relative to their mean; `None` where
    /// a light has an extent, which this method does not support.
    pub deviation: Option<f64>,
}

impl Literal {
    /// Renders as many pixels as fit into about `budget_s`.
    pub fn measure(stage: &Stage, triangles: &[[DVec3; 3]], budget_s: f64) -> Self {
        let all = stage.size.width * stage.size.height;
        let (_, pilot_s) = timed(|| shafts(stage, triangles, 4.min(all)));
        let pixels = (budget_s / pilot_s.max(1e-9) * 4.0).clamp(4.0, 4096.0) as usize;
        let pixels = pixels.min(all);
        let (found, seconds) = timed(|| shafts(stage, triangles, pixels));
        let (depth_m, step_m) = stage.planes;
        let transport = Transport {
            volume: VolumeMethod::March(MarchSteps::Planes { depth_m, step_m }),
            mirror_depth: 0,
            indirect: None,
            features: false,
        };
        let mut scratch = Scratch::default();
        let mut through_tree = |ray: &Ray| {
            radiance(stage.snapshot(), &transport, ray, &mut Sampler::new(0, 0, 0, 0), &mut scratch).shafts
        };
        let (mut square, mut sum) = (0.0, 0.0);
        for (ray, shafts) in rays(stage, pixels).zip(found) {
            let expected = through_tree(&ray);
            square += (shafts - expected).length_squared();
            sum += expected.element_sum();
        }
        let count = 3.0 * pixels as f64;
        let comparable = stage.snapshot().lights.iter().all(Luminaire::is_delta);
        let relative = if sum > 0.0 { (square / count).sqrt() / (sum / count) } else { 0.0 };
        let deviation = comparable.then_some(relative);
        Self { pixels, picture_s: seconds / pixels as f64 * all as f64, deviation }
    }
}

/// Depth along the view axis to which the image plane must be moved, metres: to the first surface, or to the
/// end of the fog.
pub fn depth_m(snapshot: &Snapshot) -> f64 {
    const GRID: usize = 64;
    let place = |index: usize| (index as f64 + 0.5) / GRID as f64;
    let rays = (0..GRID * GRID).map(|index| snapshot.view.ray(place(index % GRID), place(index / GRID)));
    let depths = rays.filter_map(|ray| {
        let hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None);
        let (_, end) = snapshot.medium.range(&ray, hit.map_or(f64::INFINITY, |hit| hit.t))?;
        Some(snapshot.view.depth(ray.at(end)))
    });
    depths.fold(0.0, f64::max)
}

/// Rays through the centres of `count` pixels, evenly distributed.
fn rays(stage: &Stage, count: usize) -> impl Iterator<Item = Ray> {
    let (width, height) = (stage.size.width, stage.size.height);
    (0..count).map(move |index| {
        let pixel = (2 * index + 1) * width * height / (2 * count);
        let (x, y) = (pixel % width, pixel / width);
        stage.snapshot().view.ray((x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64)
    })
}

/// In-scattered light for each of these rays; traces the surface's shadow ray, too, as for a whole picture.
fn shafts(stage: &Stage, triangles: &[[DVec3; 3]], count: usize) -> Vec<Rgb> {
    rays(stage, count)
        .map(|ray| {
            let nearest = triangles
                .iter()
                .filter_map(|triangle| distance(triangle, &ray))
                .fold(f64::INFINITY, f64::min);
            let mut sum = Rgb::ZERO;
            // A light with an extent counts as its centre, as for its authors.
            for light in &stage.snapshot().lights {
                let light = &light.centre();
                sum += scattered(stage, triangles, light, &ray, nearest);
                if nearest.is_finite() {
                    std::hint::black_box(is_lit(triangles, light, ray.at(nearest)));
                }
            }
            sum
        })
        .collect()
}

fn scattered(stage: &Stage, triangles: &[[DVec3; 3]], light: &FrozenLight, ray: &Ray, nearest: f64) -> Rgb {
    let (snapshot, (depth_m, step_m)) = (stage.snapshot(), stage.planes);
    let Some((_, end)) = snapshot.medium.range(ray, nearest) else { return Rgb::ZERO };
    // The image plane moves along the view axis, this ray's point on it along the ray.
    let ray_from_axis = 1.0 / snapshot.view.depth(ray.direction);
    let step = step_m * ray_from_axis;
    let reach = end.min(depth_m * ray_from_axis);
    let mut sum = Rgb::ZERO;
    for index in 0..(reach / step).ceil() as usize {
        let t = (index as f64 + 0.5) * step;
        let point = ray.at(t);
        if t >= end {
            break;
        }
        if is_lit(triangles, light, point) {
            let (to_light, light_distance, arriving) = light.arriving_at(point);
            let tau = snapshot.medium.optical_depth(point, to_light, light_distance)
                + snapshot.medium.optical_depth(ray.origin, ray.direction, t);
            let scattering = snapshot.medium.scattering_at(point, to_light.dot(ray.direction));
            sum += step * scattering * arriving * exp_minus(tau);
        }
    }
    sum
}

fn is_lit(triangles: &[[DVec3; 3]], light: &FrozenLight, point: DVec3) -> bool {
    let (to_light, light_distance, _) = light.arriving_at(point);
    let ray = Ray { origin: point, direction: to_light };
    !triangles.iter().any(|triangle| distance(triangle, &ray).is_some_and(|t| t < light_distance))
}

/// Distance along a ray to a triangle (Moeller & Trumbore 1997).
fn distance([a, b, c]: &[DVec3; 3], ray: &Ray) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = ray.direction.cross(ac);
    let inverse = 1.0 / ab.dot(p);
    let from_a = ray.origin - a;
    let v = from_a.dot(p) * inverse;
    if !(0.0..=1.0).contains(&v) {
        return None;
    }
    let q = from_a.cross(ab);
    let w = ray.direction.dot(q) * inverse;
    let t = ac.dot(q) * inverse;
    (w >= 0.0 && v + w <= 1.0 && t > 0.0).then_some(t)
}
