//! Emissive surfaces as a light for sampling. In go a snapshot's triangles and their emission, out come
//! points on them, with a density by emission. Invariant: every point that emits has a positive density.

use super::{Luminaire, Snapshot};
use crate::accel::PrimitiveId;
use crate::color::{Rgb, luminance};
use crate::light::{Emission, FrozenLight, LampShape};
use crate::math::Ray;
use glam::DVec3;
use std::ops::Range;

/// Maximum number of lights that represent emissive surfaces, and the number of points of each.
const MOST_LIGHTS: usize = 16;
const POINTS: usize = 256;
/// Steps of an additive recurrence in two dimensions (Roberts 2018, "The unreasonable effectiveness of
/// quasirandom sequences").
const SPREAD: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

/// Maximum number of triangles that rays sample one by one; more of them light the scene by the grid alone.
const MOST_LOOKED_FOR: usize = 1 << 16;

/// Maximum number of bodies that are sampled by distance.
const MOST_BODIES: usize = 64;

/// Emissive triangles, from which points are sampled by power.
pub struct EmissiveSurfaces {
    triangles: Vec<PrimitiveId>,
    /// Sums of area times luminance, textures aside, up to and including each triangle.
    up_to: Vec<f64>,
    /// Separate bodies, in the order of their triangles.
    bodies: Vec<Body>,
}

/// Triangles of one instance, or of all instances.
struct Body {
    triangles: Range<usize>,
    /// Sum of area times luminance.
    power: f64,
    middle: DVec3,
    squared_radius: f64,
}

impl Body {
    /// Estimate of its irradiance at a place.
    fn weight(&self, place: DVec3) -> f64 {
        self.power / (place.distance_squared(self.middle) + self.squared_radius)
    }

    /// Integral of that estimate over a range of a ray.
    fn weight_along(&self, ray: &Ray, (start, end): (f64, f64)) -> f64 {
        let nearest = (self.middle - ray.origin).dot(ray.direction);
        let gap = (ray.at(nearest).distance_squared(self.middle) + self.squared_radius).sqrt();
        self.power * (((end - nearest) / gap).atan() - ((start - nearest) / gap).atan()) / gap
    }
}

impl EmissiveSurfaces {
    /// Collects the emissive triangles; `None` if there are none.
    pub(super) fn of(snapshot: &Snapshot) -> Option<Self> {
        if snapshot.materials.iter().all(|material| material.emission == Rgb::ZERO) {
            return None;
        }
        let (mut triangles, mut up_to, mut all) = (Vec::new(), Vec::new(), 0.0);
        for mesh in (0..snapshot.mesh_count()).map(|number| snapshot.mesh(number)) {
            for (primitive, _) in mesh.triangles() {
                let brightness = luminance(snapshot.emission(primitive));
                if brightness > 0.0 {
                    let [a, b, c] = snapshot.corners(primitive);
                    all += brightness * 0.5 * (b - a).cross(c - a).length();
                    triangles.push(primitive);
                    up_to.push(all);
                }
            }
        }
        let mut emissive = Self { triangles, up_to, bodies: Vec::new() };
        emissive.bodies =
            emissive.parted(MOST_BODIES).into_iter().map(|range| emissive.body(snapshot, range)).collect();
        (all > 0.0 && all.is_finite()).then_some(emissive)
    }

    /// Triangles by instance, or all of them together if there are too many instances.
    fn parted(&self, most: usize) -> Vec<Range<usize>> {
        let mut end = 0;
        let of_instances = self.triangles.chunk_by(|a, b| a.instance == b.instance).map(|triangles| {
            end += triangles.len();
            end - triangles.len()..end
        });
        let ranges: Vec<Range<usize>> = of_instances.collect();
        if ranges.len() > most { Vec::from([Range { start: 0, end }]) } else { ranges }
    }

    fn body(&self, snapshot: &Snapshot, triangles: Range<usize>) -> Body {
        let corners =
            || self.triangles[triangles.clone()].iter().flat_map(|&triangle| snapshot.corners(triangle));
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let power = self.before(triangles.end) - self.before(triangles.start);
        let squared_radius = 0.25 * low.distance_squared(high);
        Body { triangles, power, middle: low.midpoint(high), squared_radius }
    }

    /// Sum of area times luminance of all triangles before one.
    fn before(&self, triangle: usize) -> f64 {
        triangle.checked_sub(1).map_or(0.0, |last| self.up_to[last])
    }

    /// Whether rays sample its light, for sharp shadows and detail nearby.
    pub fn is_looked_for(&self) -> bool {
        // If many bodies are sampled by power alone, most samples are far away: noise, where a grid has none.
        let are_apart = self.bodies.len() == self.parted(usize::MAX).len();
        are_apart && self.triangles.len() <= MOST_LOOKED_FOR
    }

    /// Luminaires of emissive surfaces: one for each body, or one for all of them if they are many.
    pub fn luminaires(&self, snapshot: &Snapshot) -> Vec<Luminaire> {
        let bodies = self.parted(MOST_LIGHTS).into_iter();
        bodies.filter_map(|triangles| self.luminaire(snapshot, &triangles)).collect()
    }

    /// Luminaire of points on some triangles, each of which emits to one side.
    fn luminaire(&self, snapshot: &Snapshot, triangles: &Range<usize>) -> Option<Luminaire> {
        /// Offset from the surface, relative to its size, so that no light starts behind it.
        const OFF: f64 = 1e-4;
        let all = self.before(triangles.end) - self.before(triangles.start);
        if all <= 0.0 {
            return None;
        }
        // One half of the points after the other, so that a few evenly chosen points include both sides.
        let half = POINTS / 2;
        let point = |number: usize| {
            let within = (number % half) as f64 + 0.5;
            let primitive = self.triangle_at(triangles, within / half as f64);
            let corners = snapshot.corners(primitive);
            let place = evenly(corners, SPREAD.map(|step| (within * step).fract()));
            let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let up = across.normalize_or_zero();
            let normal = if number < half { up } else { -up };
            let ray = Ray { origin: place + normal, direction: -normal };
            let seen = snapshot.facet(primitive).seen_along(&ray, 1.0);
            let per_m2 = luminance(snapshot.emission(primitive)) / all;
            FrozenLight::Point {
                position: place + OFF * across.length().sqrt() * normal,
                intensity: 2.0 * seen.alpha * seen.emission / per_m2,
                emission: Emission::Flat { normal },
                shape: LampShape::NONE,
            }
        };
        Luminaire::of_points((0..POINTS).map(point).collect())
    }

    /// The triangle among some that a uniform number samples by power.
    fn triangle_at(&self, triangles: &Range<usize>, u: f64) -> PrimitiveId {
        let (before, end) = (self.before(triangles.start), self.before(triangles.end));
        let up_to = before + u * (end - before);
        let among = &self.up_to[triangles.clone()];
        let number = among.partition_point(|&sum| sum <= up_to).min(among.len() - 1);
        self.triangles[triangles.start + number]
    }

    /// A point that three uniform numbers sample for a place to be lit, and its triangle.
    pub fn sample(&self, snapshot: &Snapshot, place: DVec3, u: [f64; 3]) -> (PrimitiveId, DVec3) {
        let (triangle, point, _) = self.sample_by(snapshot, |body| body.weight(place), u);
        (triangle, point)
    }

    /// As [`Self::sample`], for a range of a ray to be lit; with its probability density, 1/m^2.
    pub fn sample_along(
        &self,
        snapshot: &Snapshot,
        (ray, range): (&Ray, (f64, f64)),
        u: [f64; 3],
    ) -> (PrimitiveId, DVec3, f64) {
        self.sample_by(snapshot, |body| body.weight_along(ray, range), u)
    }

    fn sample_by(
        &self,
        snapshot: &Snapshot,
        weight: impl Fn(&Body) -> f64,
        [which, u, v]: [f64; 3],
    ) -> (PrimitiveId, DVec3, f64) {
        let all: f64 = self.bodies.iter().map(&weight).sum();
        let (mut left, mut chosen) = (which * all, 0);
        // The remainder of a number that decided is uniform again.
        while chosen + 1 < self.bodies.len() && left >= weight(&self.bodies[chosen]) {
            left -= weight(&self.bodies[chosen]);
            chosen += 1;
        }
        let body = &self.bodies[chosen];
        let of_body = weight(body);
        let triangle = self.triangle_at(&body.triangles, (left / of_body).clamp(0.0, 1.0));
        let per_m2 = luminance(snapshot.emission(triangle)) / body.power * of_body / all;
        (triangle, evenly(snapshot.corners(triangle), [u, v]), per_m2)
    }

    /// Approximate share of its light at a place that comes from near bodies, from 0 to 1: 0 if all are small
    /// and far.
    pub fn nearness(&self, place: DVec3) -> f64 {
        let of_body = |body: &Body| {
            let nearness = body.squared_radius / (place.distance_squared(body.middle) + body.squared_radius);
            body.weight(place) * nearness
        };
        self.bodies.iter().map(of_body).sum::<f64>() / self.weight(place)
    }

    /// Probability density of [`Self::sample`] for points of a triangle, 1/m^2; 0 if it does not emit.
    pub fn pdf_per_m2(&self, snapshot: &Snapshot, place: DVec3, primitive: PrimitiveId) -> f64 {
        let brightness = luminance(snapshot.emission(primitive));
        if brightness <= 0.0 {
            return 0.0;
        }
        let instance = |body: &Body| self.triangles[body.triangles.start].instance;
        let number = self.bodies.partition_point(|body| instance(body) <= primitive.instance);
        let body = &self.bodies[number.saturating_sub(1)];
        brightness / body.power * body.weight(place) / self.weight(place)
    }

    fn weight(&self, place: DVec3) -> f64 {
        self.bodies.iter().map(|body| body.weight(place)).sum()
    }
}

/// A uniformly distributed point of a triangle: Pharr, Jakob & Humphreys 2023, "Physically Based Rendering",
/// section 6.5.3.
fn evenly([a, b, c]: [DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
    let root = u.sqrt();
    a + root * ((1.0 - v) * (b - a) + v * (c - a))
}

impl Snapshot<'_> {
    /// Emissive surfaces, collected on first use; `None` if there are none.
    pub fn emissive(&self) -> Option<&EmissiveSurfaces> {
        self.emissive.get_or_init(|| EmissiveSurfaces::of(self)).as_ref()
    }

    /// Radiance that a triangle's material emits, without its texture and vertex colours.
    pub fn emission(&self, primitive: PrimitiveId) -> Rgb {
        let instance = &self.scene.instances[self.placed[primitive.instance as usize].instance()];
        let triangle = &self.scene.meshes[instance.mesh].triangles[primitive.triangle as usize];
        self.materials[instance.material.unwrap_or(triangle.material)].emission
    }
}
