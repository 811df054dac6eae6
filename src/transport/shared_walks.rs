//! Walks that the camera rays of a group share. In go the second vertices of their walks with the light that
//! arrives there, out comes what each camera ray sees of it. Invariant: a second vertex may be found by the
//! walks of any ray of the group, and the weights of all of them add up to 1.
//!
//! A walk is long, and a ray between two vertices is short. So each walk serves all rays that see its second
//! vertex (Bekaert, Sbert & Halton 2002, "Accelerating path tracing by re-using paths"), weighted by the
//! balance heuristic (see `connection.rs`). In a room each ray then has the walks of all. Rays of a group lie
//! far apart, so that neighbours in the picture have noise of their own. Surfaces share with surfaces, and
//! places in fog with such places. Second vertices in fog are not shared: light that arrives there is sampled
//! for one direction of scattering, and in others it would have more noise.

use super::connection::{per_sr, visibility};
use super::direct::scattered_per_radiance;
use super::lobes::Lobes;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::fog::henyey_greenstein_pdf;
use crate::math::Ray;
use crate::snapshot::{Snapshot, SurfacePoint};
use glam::DVec3;

/// First vertices of a camera ray whose walks are shared.
#[derive(Default)]
pub struct Roots {
    pub(super) on_surface: Option<Root>,
    pub(super) in_fog: Vec<Root>,
}

/// First vertex of a walk.
#[allow(clippy::large_enum_variant, reason = "surfaces are not fewer")]
pub(super) enum First {
    Surface(SurfacePoint),
    /// A place in fog, with its ray from the eye.
    Fog(Ray),
}

/// First vertex of walks, with their second vertices.
pub(super) struct Root {
    first: First,
    /// Throughput from it to the eye.
    throughput: Rgb,
    /// Number of walks from it, and its share in a mean over first vertices of the camera ray.
    count: u32,
    share: f64,
    seconds: Vec<Second>,
}

/// Second vertex of a walk, a matte surface.
pub(super) struct Second {
    pub(super) point: SurfacePoint,
    /// Probability density of it, 1/m^2.
    pub(super) density: f64,
    /// Estimates of the radiance that arrives there: directions, and radiance over their density.
    pub(super) arriving: Vec<(DVec3, Rgb)>,
}

/// A second vertex and its way to a root.
struct Connected {
    /// As seen from the root.
    point: SurfacePoint,
    /// Share of its radiance that the root scatters to the eye, 1/m^2.
    reached: Rgb,
    /// Number of the root's walks that meet it, 1/m^2. It may be approximate, as weights alone use it.
    walks: f64,
}

impl Root {
    pub(super) fn new(first: First, throughput: Rgb, (count, share): (u32, f64)) -> Self {
        Self { first, throughput, count, share, seconds: Vec::new() }
    }

    /// Probability density of a second vertex, from the throughput of a walk that met it.
    pub(super) fn density(&self, snapshot: &Snapshot, met: &SurfacePoint, throughput: Rgb) -> Option<f64> {
        over(self.throughput * self.connected(snapshot, met, true)?.reached, throughput)
    }

    pub(super) fn keep(&mut self, second: Second) {
        self.seconds.push(second);
    }

    /// A second vertex from here; `None` if it is hidden or shows its other side.
    fn connected(&self, snapshot: &Snapshot, met: &SurfacePoint, is_own: bool) -> Option<Connected> {
        let (place, leaving) = self.first.place();
        let way = met.position - place;
        let (direction, distance) = (way.try_normalize()?, way.length());
        let [scattered, pdf] = self.first.scattered_from(snapshot, direction);
        if pdf == Rgb::ZERO || scattered == Rgb::ZERO || leaving == Some(met.primitive) {
            return None;
        }
        let ray = Ray { origin: place, direction };
        let point = snapshot.facet(met.primitive).seen_along(&ray, distance);
        // Its two sides are met by different walks.
        if point.geometric_normal.dot(met.geometric_normal) <= 0.0 {
            return None;
        }
        if !is_own && visibility(snapshot, &ray, distance, [leaving, Some(met.primitive)]) == Rgb::ZERO {
            return None;
        }
        let per_m2 =
            snapshot.medium.transmittance(place, direction, distance) / per_sr(1.0, &point, distance);
        let walks = f64::from(self.count) * (pdf * per_m2).element_sum() / 3.0;
        let reached = scattered * per_m2;
        (walks > 0.0 && walks.is_finite()).then_some(Connected { point, reached, walks })
    }
}

impl First {
    fn place(&self) -> (DVec3, Option<PrimitiveId>) {
        match self {
            Self::Surface(point) => (point.position, Some(point.primitive)),
            Self::Fog(ray) => (ray.origin, None),
        }
    }

    /// Share of the radiance from a direction that is scattered towards the eye, 1/sr, in fog 1/(m sr); and
    /// the density with which walks sample that direction, 1/sr.
    fn scattered_from(&self, snapshot: &Snapshot, direction: DVec3) -> [Rgb; 2] {
        let (scattered, pdf) = match self {
            Self::Surface(point) => {
                let pdf = Lobes::of(point).map_or(0.0, |lobes| lobes.pdf(point, direction));
                (scattered_per_radiance(point, direction), pdf)
            }
            Self::Fog(ray) => {
                let (medium, cos) = (&snapshot.medium, ray.direction.dot(direction));
                let pdf = henyey_greenstein_pdf(medium.anisotropy_at(ray.origin), cos);
                (medium.scattering_at(ray.origin, cos), pdf)
            }
        };
        [scattered, Rgb::splat(pdf)]
    }
}

/// Ratio of two colours that are the same but for a factor; `None` for black.
pub(super) fn over(value: Rgb, factored: Rgb) -> Option<f64> {
    let most = factored.max_element();
    let ratio = (0..3).find(|&channel| factored[channel] == most).map(|channel| value[channel] / most);
    ratio.filter(|ratio| *ratio > 0.0 && ratio.is_finite())
}

/// Light of shared walks that camera rays see: on their surfaces, and in fog.
pub fn shared_light(snapshot: &Snapshot, group: &[Roots]) -> Vec<[Rgb; 2]> {
    let mut sums = vec![[Rgb::ZERO; 2]; group.len()];
    let mut share = |pass: usize, root_of: &dyn Fn(&Roots) -> Option<&Root>| {
        let (numbers, roots): (Vec<usize>, Vec<&Root>) =
            (0..group.len()).filter_map(|number| root_of(&group[number]).map(|root| (number, root))).unzip();
        for (number, light) in numbers.into_iter().zip(light_of(snapshot, &roots)) {
            sums[number][pass] += light;
        }
    };
    share(0, &|roots| roots.on_surface.as_ref());
    let most = group.iter().map(|roots| roots.in_fog.len()).max().unwrap_or(0);
    for branch in 0..most {
        share(1, &|roots| roots.in_fog.get(branch));
    }
    sums
}

/// Light of all second vertices, at each of the roots.
fn light_of(snapshot: &Snapshot, roots: &[&Root]) -> Vec<Rgb> {
    let mut sums = vec![Rgb::ZERO; roots.len()];
    for (own, root) in roots.iter().enumerate() {
        for second in &root.seconds {
            let seen: Vec<Option<Connected>> = (0..roots.len())
                .map(|number| roots[number].connected(snapshot, &second.point, number == own))
                .collect();
            let all: f64 = seen.iter().flatten().map(|seen| seen.walks).sum();
            let Some(by_own) = &seen[own] else { continue };
            let weight = by_own.walks / (f64::from(root.count) * all * second.density);
            for (sum, (root, seen)) in sums.iter_mut().zip(roots.iter().zip(&seen)) {
                let Some(seen) = seen else { continue };
                let scattered = |&(direction, radiance): &(DVec3, Rgb)| {
                    scattered_per_radiance(&seen.point, direction) * radiance
                };
                let radiance: Rgb = second.arriving.iter().map(scattered).sum();
                *sum += root.throughput * seen.reached * radiance * (root.share * weight);
            }
        }
    }
    sums
}
