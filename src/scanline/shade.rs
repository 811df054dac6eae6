//! Shading of samples. In goes the visibility of a band, out come its pixels. Invariant: a pixel is shaded
//! once for each of its triangles, for any number of samples that show the triangle.

use super::bands::{Bands, NOTHING, Visible};
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{Facet, FrozenLight, Snapshot};
use crate::transport::unshadowed;
use glam::DVec2;

pub(super) struct Shader<'a> {
    snapshot: &'a Snapshot<'a>,
    bands: &'a Bands,
    /// Lights; those with an extent are replaced by their centres.
    lights: Vec<FrozenLight>,
    is_dark_beyond: bool,
    /// The last triangle, as neighbouring samples often show the same.
    facet: Option<(u32, Facet<'a>)>,
    /// Shaded triangles of the current pixel.
    shaded: Vec<(u32, Shaded)>,
}

/// Radiance and transmittance of a triangle.
#[derive(Clone, Copy)]
struct Shaded {
    radiance: Rgb,
    see_through: Rgb,
}

impl<'a> Shader<'a> {
    pub(super) fn new(snapshot: &'a Snapshot<'a>, bands: &'a Bands) -> Self {
        let lights = snapshot.lights.iter().map(|light| light.centre()).collect();
        let is_dark_beyond = snapshot.is_dark_beyond();
        Self { snapshot, bands, lights, is_dark_beyond, facet: None, shaded: Vec::new() }
    }

    /// Red, green, blue and alpha of the band's pixels, row by row.
    pub(super) fn shade(mut self, visible: &Visible, pixels: &mut [[f32; 4]]) {
        let (width, samples) = (self.bands.size.width, self.bands.lattices.len());
        let mut layers = visible.layers.as_slice();
        for (pixel, shown) in pixels.iter_mut().enumerate() {
            let corner = DVec2::new((pixel % width) as f64, (visible.rows.start + pixel / width) as f64);
            self.shaded.clear();
            let mut sum = Rgb::ZERO;
            let mut alpha = 0.0;
            let mut alpha_beyond = None;
            for (place, lattice) in self.bands.lattices.iter().enumerate() {
                let sample = pixel * samples + place;
                let at = corner + lattice.offset;
                let nearest = visible.nearest[sample];
                let (mut color, own_alpha) = match nearest {
                    NOTHING => {
                        (self.radiance_beyond(at), *alpha_beyond.get_or_insert_with(|| self.alpha_beyond(at)))
                    }
                    _ if self.is_hole(nearest) => {
                        (Rgb::ZERO, self.alpha_of_fog(at, self.distance(at, visible.depths[sample])))
                    }
                    _ => (self.shaded(nearest, at, visible.depths[sample]).radiance, 1.0),
                };
                let count = layers.iter().take_while(|layer| layer.sample == sample).count();
                for layer in &layers[..count] {
                    let Shaded { radiance, see_through } = self.shaded(layer.triangle, at, layer.depth);
                    color = radiance + see_through * color;
                }
                layers = &layers[count..];
                sum += color;
                alpha += own_alpha;
            }
            let [r, g, b] = (sum / samples as f64).as_vec3().to_array();
            *shown = [r, g, b, (alpha / samples as f64) as f32];
        }
    }

    fn ray(&self, at: DVec2) -> Ray {
        let size = self.bands.size;
        self.snapshot.view.ray(at.x / size.width as f64, at.y / size.height as f64)
    }

    /// Radiance of the background, for every sample, as suns have edges.
    fn radiance_beyond(&self, at: DVec2) -> Rgb {
        if self.is_dark_beyond {
            return Rgb::ZERO;
        }
        let ray = self.ray(at);
        match self.snapshot.seen_beyond(ray.direction) {
            Rgb::ZERO => Rgb::ZERO,
            radiance => {
                radiance * self.snapshot.medium.transmittance(ray.origin, ray.direction, f64::INFINITY)
            }
        }
    }

    /// Alpha of the background, once for each pixel, as fog is smooth.
    fn alpha_beyond(&self, at: DVec2) -> f64 {
        if self.snapshot.has_background() {
            return 1.0;
        }
        self.alpha_of_fog(at, f64::INFINITY)
    }

    fn alpha_of_fog(&self, at: DVec2, distance: f64) -> f64 {
        let ray = self.ray(at);
        let through = self.snapshot.medium.transmittance(ray.origin, ray.direction, distance);
        1.0 - through.element_sum() / 3.0
    }

    /// Distance along the ray, from a depth along the view axis.
    fn distance(&self, at: DVec2, depth: f64) -> f64 {
        depth / self.ray(at).direction.dot(self.snapshot.view.axes().2)
    }

    fn is_hole(&self, triangle: u32) -> bool {
        self.snapshot.is_holdout(self.bands.triangles[triangle as usize].primitive)
    }

    /// Shades a triangle for the current pixel, at the first of its samples.
    fn shaded(&mut self, triangle: u32, at: DVec2, depth: f64) -> Shaded {
        if let Some((_, shaded)) = self.shaded.iter().find(|(known, _)| *known == triangle) {
            return *shaded;
        }
        let facet = match self.facet {
            Some((known, facet)) if known == triangle => facet,
            _ => self.snapshot.facet(self.bands.triangles[triangle as usize].primitive),
        };
        self.facet = Some((triangle, facet));
        let ray = self.ray(at);
        let distance = self.distance(at, depth);
        let point = facet.seen_along(&ray, distance);
        let fog = self.snapshot.medium.transmittance(ray.origin, ray.direction, distance);
        // Mirrors show the background alone.
        let normal = point.shading_normal;
        let mirrored = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
        let mirrored = point.mirror * self.snapshot.radiance_beyond(mirrored);
        let light = match self.is_hole(triangle) {
            true => Rgb::ZERO,
            false => unshadowed(&self.lights, &point) + point.emission + mirrored,
        };
        let shaded = Shaded { radiance: fog * point.alpha * light, see_through: point.see_through };
        self.shaded.push((triangle, shaded));
        shaded
    }
}
