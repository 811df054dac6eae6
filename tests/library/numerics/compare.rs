//! The renderer against the truth: the same rays by the per-ray method and by slices. In go a scene
//! and places in the picture, out come errors. Whatever a ray is said to meet must be something that
//! it may meet (no leak), and every value must be finite.

use crate::common::{EXACT, INSTANT};
use crate::numerics::truth::{Candidate, Truth};
use glam::DVec2;
use std::fmt;
use sunfleck::color::Rgb;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{Scene, Size};
use sunfleck::snapshot::{FrozenLight, Luminaire, MeshTrees, Snapshot};
use sunfleck::transport::slices::{Fan, Piece, Ring, SliceJob, SliceScratch};
use sunfleck::transport::{Sample, Scratch, radiance};

/// What a comparison found.
#[derive(Debug, Default)]
pub(crate) struct Errors {
    /// How many rays were compared.
    pub(crate) rays: usize,
    /// Rays that meet something where the truth has nothing, or the other way round.
    pub(crate) leaks: usize,
    /// Rays whose surface is lit in one and dark in the other.
    pub(crate) misjudged: usize,
    /// Values that rounding decides about: surfaces, in visibility or in light, and rays in line with it.
    pub(crate) undecided: usize,
    sum: f64,
    squares: f64,
    surface_sum: f64,
    surface_squares: f64,
    /// The most light from the fog that any ray has.
    pub(crate) brightest: f64,
    /// The largest error of the shafts, and where.
    worst: f64,
    worst_ray: Option<Ray>,
}

impl Errors {
    /// Relative RMSE of the light from the fog.
    pub(crate) fn shafts(&self) -> f64 {
        relative_rmse(self.squares, self.sum, self.rays)
    }

    /// Relative RMSE of the light from surfaces, misjudged ones left out.
    pub(crate) fn surfaces(&self) -> f64 {
        relative_rmse(self.surface_squares, self.surface_sum, self.rays)
    }

    fn add(&mut self, truth: &Truth, ray: &Ray, cos_view: f64, sample: &Sample) {
        self.rays += 1;
        let values = [sample.radiance, sample.shafts, sample.transmittance];
        assert!(ray.direction.is_finite(), "{ray:?}");
        let is_sane = values.iter().all(|value| value.is_finite() && value.min_element() >= 0.0);
        assert!(is_sane, "{sample:?} of {ray:?}");
        assert!((0.0..=1.0).contains(&sample.alpha), "{sample:?}");
        let t = sample.surface.map_or(f64::INFINITY, |surface| surface.depth_m / cos_view);
        assert!(t > 0.0, "{sample:?} of {ray:?}");
        let candidates = truth.candidates(ray);
        let met = candidates.iter().find(|met| met.holds(t));
        let may_be_nothing = !candidates.iter().any(|met| met.is_certain);
        if met.is_none() && (t.is_finite() || !may_be_nothing) {
            if self.leaks == 0 {
                println!("leak: {ray:?} at {t}, not one of {candidates:?}");
            }
            self.leaks += 1;
            return;
        }
        let expected = truth.light(ray, met, t);
        self.brightest = self.brightest.max(sample.shafts.max_element());
        match expected.shafts {
            None => self.undecided += 1,
            Some(shafts) => {
                let error = (sample.shafts - shafts).length();
                self.sum += shafts.length();
                self.squares += error * error;
                if error > self.worst {
                    (self.worst, self.worst_ray) = (error, Some(*ray));
                }
            }
        }
        assert!(close(sample.transmittance, expected.transmittance), "{sample:?} {expected:?}");
        let surface = sample.radiance - sample.shafts;
        match expected.surface {
            None => self.undecided += 1,
            Some(light) => {
                let light = light * expected.transmittance;
                // What is left of the surface behind much fog is lost in the sum with the shafts; what is
                // left of light in its own plane is rounding.
                let lost = 1e-14 * sample.shafts.length() + 1e-13;
                let error = ((surface - light).length() - lost).max(0.0);
                if error > 0.01 * light.length().max(surface.length()) {
                    if self.misjudged == 0 {
                        println!("misjudged: {ray:?} at {t}: {surface} not {light}");
                    }
                    self.misjudged += 1;
                } else {
                    self.surface_sum += light.length();
                    self.surface_squares += error * error;
                }
            }
        }
    }

    /// Where light itself is a matter of rounding: values are finite, surfaces those that there are.
    pub(crate) fn hold_sane(&self, what: &str) {
        println!("{what}: {} rays, shafts {:.1e}, leaks {}", self.rays, self.shafts(), self.leaks);
        assert!(self.rays > 0 && self.leaks == 0, "{what}: {} leaks", self.leaks);
    }

    /// Prints a line, so that `--nocapture` shows what was measured, and holds the bounds.
    pub(crate) fn hold(&self, what: &str, bound: f64) {
        println!("{what}: {self}");
        assert!(self.undecided < self.rays, "{what}: the truth decides too little");
        assert_eq!(self.verdict(bound), Ok(()), "{what}");
    }

    /// What is wrong, if anything is. The truth may have had nothing to say.
    pub(crate) fn verdict(&self, bound: f64) -> Result<(), String> {
        self.verdict_above(0.0, bound)
    }

    /// The same, where less light than `floor` on average counts as that much.
    pub(crate) fn verdict_above(&self, floor: f64, bound: f64) -> Result<(), String> {
        let mean = self.sum / self.rays as f64;
        let share = if mean < floor { mean / floor } else { 1.0 };
        let is_good = self.rays > 0
            && (self.leaks, self.misjudged) == (0, 0)
            && share * self.shafts() <= bound
            && self.surfaces() <= bound;
        if is_good { Ok(()) } else { Err(format!("{self}, at {:?}", self.worst_ray)) }
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} rays, shafts {:.1e} (largest {:.1e}, mean {:.1e}), surfaces {:.1e}, leaks {}, misjudged {}, undecided {}",
            self.rays,
            self.shafts(),
            self.worst / (self.sum / self.rays as f64),
            self.sum / self.rays as f64,
            self.surfaces(),
            self.leaks,
            self.misjudged,
            self.undecided
        )
    }
}

impl Candidate {
    fn holds(&self, t: f64) -> bool {
        let slack = if self.is_certain { 1e-9 } else { 1e-6 };
        (self.t.0 - slack * t.abs()..=self.t.1 + slack * t.abs()).contains(&t)
    }
}

fn relative_rmse(squares: f64, sum: f64, count: usize) -> f64 {
    // Nothing lit at all: what is left is the rounding of the ends of shadows, in W/(m2 sr).
    if sum == 0.0 && squares <= 1e-12 * count as f64 {
        0.0
    } else {
        (squares / count as f64).sqrt() / (sum / count as f64)
    }
}

fn close(a: Rgb, b: Rgb) -> bool {
    (a - b).abs().max_element() <= 1e-9 * a.max_element().max(1e-300)
}

/// The per-ray method on the rays through film positions in `[0, 1]^2`.
pub(crate) fn per_ray(scene: &Scene, aspect: f64, places: impl Iterator<Item = (f64, f64)>) -> Errors {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, aspect, INSTANT);
    let rays: Vec<Ray> = places.map(|(x, y)| snapshot.view.ray(x, y)).collect();
    per_ray_of(scene, &snapshot, rays.into_iter())
}

/// The per-ray method on any rays from the camera.
pub(crate) fn per_ray_of(scene: &Scene, snapshot: &Snapshot, rays: impl Iterator<Item = Ray>) -> Errors {
    let truth = Truth::new(scene, snapshot);
    let mut scratch = Scratch::default();
    let mut errors = Errors::default();
    for ray in rays {
        let mut sampler = Sampler::new(0, 0, 0, 0);
        let sample = radiance(snapshot, &EXACT, &ray, &mut sampler, &mut scratch);
        errors.add(&truth, &ray, snapshot.view.depth(ray.direction), &sample);
    }
    errors
}

/// Which rays of the slices are compared: slices by their share of all angles, and samples on each by
/// their share of its area.
pub(crate) struct SlicePlan {
    pub(crate) size: Size,
    pub(crate) angles: Vec<f64>,
    pub(crate) areas: Vec<f64>,
}

impl SlicePlan {
    /// Even over a picture.
    pub(crate) fn even(size: Size, slices: u32, samples: u32) -> Self {
        let even = |count: u32, shift: f64| {
            (0..count).map(|index| (f64::from(index) + shift) / f64::from(count)).collect()
        };
        Self { size, angles: even(slices, 0.43), areas: even(samples, 0.37) }
    }
}

/// Slices of the scene's only light, or of the one in its middle.
pub(crate) fn by_slices(scene: &Scene, plan: &SlicePlan) -> Errors {
    by_slices_through(scene, plan, Luminaire::centre)
}
/// Slices of one point of the scene's only light.
pub(crate) fn by_slices_through(
    scene: &Scene,
    plan: &SlicePlan,
    point: impl Fn(&Luminaire) -> FrozenLight,
) -> Errors {
    let aspect = plan.size.width as f64 / plan.size.height as f64;
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, aspect, INSTANT);
    let [luminaire] = &snapshot.lights[..] else { panic!("a slice knows one light") };
    let light = point(luminaire);
    let fan = Fan::new(&snapshot.view, plan.size, DVec2::ZERO, light.place()).expect("a fan");
    let truth = Truth::lit_by(scene, &snapshot, vec![light]);
    let job = SliceJob {
        snapshot: &snapshot,
        transport: &EXACT,
        light: &light,
        hue: Rgb::ONE,
        has_rest: true,
        fan: &fan,
    };
    let mut scratch = SliceScratch::default();
    let mut errors = Errors::default();
    for share in &plan.angles {
        let angle = fan.angles.0 + share * fan.angles.1;
        let Some(slice) = fan.slice(angle, Ring::WHOLE) else { continue };
        let areas = plan.areas.iter().map(|share| share * slice.area_per_rad);
        let chords = areas.map(|area| slice.ray(area));
        job.solve(&slice, chords, None, &mut scratch, |Piece { place, .. }, value| {
            let ray = Ray { origin: fan.eye, direction: place.direction };
            errors.add(&truth, &ray, snapshot.view.depth(ray.direction), value);
        });
    }
    errors
}
