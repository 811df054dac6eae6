//! Brute force: every triangle of a scene against a ray and a light, in double precision, without any tree.
//! In go triangles relative to the camera, out come shadow intervals, and the deviation of the exact method
//! from their light. Invariant: it shares no code with the trees.

use crate::color::Rgb;
use crate::fog::LitSegments;
use crate::light::LightPlace;
use crate::math::{IntervalSet, Ray, Sampler};
use crate::scene::Scene;
use crate::snapshot::{Luminaire, Snapshot};
use crate::transport::lit_segments;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Returns all visible triangles at `time_s`, relative to `eye`.
pub fn triangles(scene: &Scene, eye: DVec3, time_s: f64) -> Vec<[DVec3; 3]> {
    let placements = scene.placements(time_s);
    let mut triangles = Vec::new();
    for instance in scene.instances.iter().filter(|instance| placements[instance.node].visible) {
        let (positions, mut relative_from_mesh) = scene.vertices(instance, &placements, time_s);
        relative_from_mesh.translation -= eye;
        for triangle in &scene.meshes[instance.mesh].triangles {
            let corner = |vertex: u32| positions[vertex as usize].as_dvec3();
            triangles
                .push(triangle.vertices.map(|vertex| relative_from_mesh.transform_point3(corner(vertex))));
        }
    }
    triangles
}

/// Deviation of the exact method from brute force.
#[derive(Clone, Copy, Debug)]
pub struct Deviation {
    /// Rays that met fog.
    pub rays: usize,
    /// Root mean square of the differences, relative to the mean.
    pub relative_rmse: f64,
    /// The largest difference, relative to the mean.
    pub largest: f64,
}

/// Compares the light scattered into `rays` rays through random places of the picture, each with a random
/// point of the light: the tree's shadows against those of all `triangles`.
pub fn deviation(
    snapshot: &Snapshot,
    triangles: &[[DVec3; 3]],
    light: &Luminaire,
    rays: u32,
    seed: u32,
) -> Deviation {
    let pairs: Vec<(f64, f64)> = (0..rays)
        .into_par_iter()
        .filter_map(|index| {
            let mut sampler = Sampler::new(seed, 0, 0, index);
            let (x, y) = sampler.next_2d();
            let light = &light.point(sampler.next_3d());
            let ray = snapshot.view.ray(x, y);
            let hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None);
            let distance = hit.map_or(f64::INFINITY, |hit| hit.t);
            let range = snapshot.medium.range(&ray, distance)?;
            let found = lit_segments(snapshot, &ray, light, range);
            let truth = shadows(triangles, &ray, light.place(), range);
            let truth = LitSegments::from_shadows(truth, range);
            let value = |lit: &LitSegments| {
                let scattered: Rgb = snapshot.medium.passage(&ray, distance, lit, light).scattered;
                scattered.element_sum() / 3.0
            };
            Some((value(&found), value(&truth)))
        })
        .collect();
    let count = pairs.len() as f64;
    let mean = pairs.iter().map(|pair| pair.1).sum::<f64>() / count;
    let square = pairs.iter().map(|pair| (pair.0 - pair.1).powi(2)).sum::<f64>() / count;
    let largest = pairs.iter().map(|pair| (pair.0 - pair.1).abs()).fold(0.0, f64::max);
    Deviation { rays: pairs.len(), relative_rmse: square.sqrt() / mean, largest: largest / mean }
}

/// Shadows of the triangles on the ray within `range`.
///
/// Each triangle is cut by the plane through ray and light; the cut's ends are projected from the light
/// onto the ray by solving the 2 x 2 system in an orthonormal basis of that plane.
pub fn shadows(triangles: &[[DVec3; 3]], ray: &Ray, light: LightPlace, range: (f64, f64)) -> IntervalSet {
    let along = ray.direction;
    let towards = match light {
        LightPlace::Towards(direction) => direction,
        LightPlace::At(position) => position - ray.origin,
    };
    let up = (towards - towards.dot(along) * along).normalize();
    let normal = along.cross(up);
    let in_plane = |p: DVec3| DVec2::new((p - ray.origin).dot(along), (p - ray.origin).dot(up));
    let light_in_plane = in_plane(ray.origin + towards);

    let mut set = IntervalSet::default();
    for corners in triangles {
        let heights = corners.map(|corner| (corner - ray.origin).dot(normal));
        let mut cut = Vec::with_capacity(2);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if (heights[i] >= 0.0) != (heights[j] >= 0.0) {
                let fraction = heights[i] / (heights[i] - heights[j]);
                cut.push(in_plane(corners[i].lerp(corners[j], fraction)));
            }
        }
        if let [a, b] = cut[..] {
            let shaded = match light {
                LightPlace::Towards(_) => shade_from_afar(a, b, light_in_plane, range),
                LightPlace::At(_) => shade_from_near(a, b, light_in_plane, range),
            };
            if let Some((start, end)) = shaded {
                set.insert(start, end);
            }
        }
    }
    set
}

/// Shadow of a cut whose points above the ray shade it along the direction `(light.0, light.1)`.
fn shade_from_afar(a: DVec2, b: DVec2, light: DVec2, range: (f64, f64)) -> Option<(f64, f64)> {
    let shear = light.x / light.y;
    shade(a, b, range, |DVec2 { x, y }| x - y * shear)
}

/// Shadow of a cut whose points between the ray and the light shade it; the part above the light is cut off.
fn shade_from_near(mut a: DVec2, mut b: DVec2, light: DVec2, range: (f64, f64)) -> Option<(f64, f64)> {
    if a.y > b.y {
        (a, b) = (b, a);
    }
    if a.y >= light.y {
        return None;
    }
    if b.y >= light.y {
        let fraction = (1.0 - 1e-13) * (light.y - a.y) / (b.y - a.y);
        b = DVec2::new(a.x + fraction * (b.x - a.x), a.y + fraction * (b.y - a.y));
    }
    shade(a, b, range, |DVec2 { x, y }| light.x + (x - light.x) * light.y / (light.y - y))
}

/// The shadow of a cut, clipped to the range; it exists only if the cut is above the ray in its middle.
fn shade(a: DVec2, b: DVec2, range: (f64, f64), on_ray: impl Fn(DVec2) -> f64) -> Option<(f64, f64)> {
    let (t_a, t_b) = (on_ray(a), on_ray(b));
    let (start, end) = (t_a.min(t_b).max(range.0), t_a.max(t_b).min(range.1));
    if start >= end {
        return None;
    }
    // Bisection finds the point of the cut that shades the middle: no formula is shared with the exact
    // method.
    let middle = 0.5 * (start + end);
    let (mut low, mut high) = (0.0, 1.0);
    let point = |f: f64| DVec2::new(a.x + f * (b.x - a.x), a.y + f * (b.y - a.y));
    for _ in 0..60 {
        let half = 0.5 * (low + high);
        if (on_ray(point(half)) < middle) == (t_a < t_b) { low = half } else { high = half }
    }
    (point(low).y > 0.0).then_some((start, end))
}
