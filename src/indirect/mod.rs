//! Light of all orders of scattering but the first: from leaf to leaf, from sky to ground, within fog. In
//! goes an exposure, out comes an [`Indirect`] that every ray may ask. Invariant: nothing in it is random,
//! and what is solved does not know the camera.
//!
//! Direct light and single scattering stay exact, in `transport`. What comes after is solved on world grids
//! by discrete ordinates (Chandrasekhar 1950, "Radiative Transfer"). Leaves and fog together are one turbid
//! medium there. `source_iteration.rs` is the loop over orders. Around the grids, fog over plain ground is a
//! stack of layers (`layers.rs`).

mod contents;
mod cut_patches;
mod extent;
mod field;
mod gathered;
mod ground;
mod highlights;
mod kept;
mod layer_detail;
mod layers;
mod leaf_light;
mod level;
mod lobe;
mod sky;
mod solved;
mod stack;
mod towards;
mod view;
mod wall_light;
mod walls;

use self::field::Field;
use self::level::Level;
use self::lobe::Lobe;
use self::solved::Solved;
use self::view::ViewedFog;
use crate::color::Rgb;
use crate::math::Ray;
use crate::scene::Bounces;
use crate::snapshot::{Exposure, Snapshot, SurfacePoint};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;
use std::ops::Range;
use std::sync::Arc;

pub use kept::KeptLight;

/// Indirect light of a shutter interval, as a camera sees it.
pub struct Indirect {
    solved: Arc<Solved>,
    fog: Option<ViewedFog>,
    /// Light after one bounce less, where that is asked for.
    once_less: Option<Box<Self>>,
}

impl Indirect {
    /// `None` where there is nothing that could scatter light. Once `cancelled` says true, what comes is of
    /// no use. `aspect` is width / height of the picture.
    pub fn new(
        exposure: &Exposure,
        bounces: Bounces,
        aspect: f64,
        kept: &KeptLight,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let solved = kept.of(exposure.contents(), bounces, cancelled)?;
        let fog = ViewedFog::new(&solved.field, exposure.middle(), aspect);
        let unseen = |solved: &Arc<Solved>| Self { solved: Arc::clone(solved), fog: None, once_less: None };
        let once_less = solved.once_less.as_ref().map(|less| Box::new(unseen(less)));
        Some(Self { solved, fog, once_less })
    }

    /// Light that was scattered once less than this, if there is any.
    pub fn once_less(&self) -> Option<&Self> {
        if self.solved.bounces == Bounces::All { Some(self) } else { self.once_less.as_deref() }
    }

    /// Side of the finest cells, metres; infinite where there are none.
    pub fn cell_m(&self) -> f64 {
        self.solved.field.levels().first().map_or(f64::INFINITY, Level::cell_m)
    }

    /// Whether next to nothing absorbs it: it goes on and on, and there is more of it than is found.
    pub fn is_endless(&self) -> bool {
        self.solved.field.is_endless()
    }

    /// Whether the sky's own light is part of it, so that nobody need look for it: not where a part of the
    /// sky is as bright as a sun, whose shadows have borders.
    pub fn has_sky(&self) -> bool {
        self.solved.has_sky
    }

    /// Whether what surfaces get straight from what glows is part of it, so that nobody need look for it: not
    /// where that is few enough triangles for rays to pick from.
    pub fn has_glow(&self) -> bool {
        self.solved.has_glow
    }

    /// Share of a surface's shine that rays are to find: harmonics are too wide for what stands near.
    pub fn share_of_rays(point: &SurfacePoint) -> f64 {
        /// Albedo of the coat from hardly seen to seen: between the two both ways count.
        const SEEN: Range<f64> = 0.05..0.1;
        /// Widths of coats, by glTF's `alpha`: from narrow to as blurred as harmonics are.
        const BLURRED: Range<f64> = 0.1..0.2;
        /// Albedo from which shine is the most that is seen, and found by rays however blurred it is.
        const MOST: Range<f64> = 0.3..0.5;
        let share =
            |range: Range<f64>, of: f64| ((of - range.start) / (range.end - range.start)).clamp(0.0, 1.0);
        let cos = point.shine_normal.dot(point.to_eye).max(0.0);
        let of_gloss = point.gloss.as_ref().map(|gloss| (gloss.albedo(cos), gloss.alpha()));
        let of_dielectric =
            point.dielectric.as_ref().map(|own| (own.albedos(cos).iter().sum(), own.alphas()[1]));
        let all = [of_gloss, of_dielectric].into_iter().flatten();
        let (shine, alpha) = all.fold((Rgb::ZERO, 1.0_f64), |all, one| (all.0 + one.0, all.1.min(one.1)));
        let shine = shine.max_element();
        share(SEEN, shine) * (1.0 - share(BLURRED, alpha)).max(share(MOST, shine))
    }

    /// Radiance that a surface scatters towards the eye, W m^-2 sr^-1, with a share of what it shows in its
    /// shine.
    pub fn scattered(&self, snapshot: &Snapshot, point: &SurfacePoint, share_of_shine: f64) -> Rgb {
        let world = snapshot.world_from_relative(point.position);
        let cos_eye = point.shine_normal.dot(point.to_eye).max(0.0);
        let of_dielectric = point.dielectric.as_ref().map_or([Rgb::ZERO; 2], |own| own.albedos(cos_eye));
        let sent = point.albedo + point.transmission + of_dielectric[0] + of_dielectric[1];
        let leaf = self.solved.leaves.of(&self.solved.field, snapshot, point.primitive);
        let gathered = |lobe: Lobe| match &leaf {
            Some(leaf) => leaf.gathered_by(&self.solved.field, &lobe, sent),
            None => self.solved.field.gathered_by(world, &lobe),
        };
        let normal = point.shading_normal;
        let mut radiance = Rgb::ZERO;
        let beneath = point.gloss.as_ref().map_or(Rgb::ONE, |gloss| gloss.leaves(cos_eye));
        if point.albedo != Rgb::ZERO {
            radiance += FRAC_1_PI * beneath * point.albedo * gathered(Lobe::cosine(normal));
        }
        if point.transmission != Rgb::ZERO {
            radiance += FRAC_1_PI * beneath * point.transmission * gathered(Lobe::cosine(-normal));
        }
        if share_of_shine == 0.0 {
            return radiance;
        }
        let normal = point.shine_normal;
        let mirrored: DVec3 = 2.0 * normal.dot(point.to_eye) * normal - point.to_eye;
        if let Some(gloss) = &point.gloss {
            let lobe = Lobe::glossy(mirrored, normal, gloss.alpha());
            radiance += share_of_shine * FRAC_1_PI * gloss.albedo(cos_eye) * gathered(lobe);
        }
        if let Some(dielectric) = &point.dielectric {
            let ([reflected, through], [alpha, alpha_through]) = (of_dielectric, dielectric.alphas());
            let seen = reflected * gathered(Lobe::glossy(mirrored, normal, alpha))
                + through
                    * gathered(Lobe::glossy(
                        dielectric.straight(normal, point.to_eye),
                        -normal,
                        alpha_through,
                    ));
            radiance += share_of_shine * FRAC_1_PI * seen;
        }
        radiance
    }

    /// Radiance that fog scatters into a camera ray before it has gone `distance` metres, if it lets
    /// `through` of what is behind it.
    pub fn seen_in_fog(&self, snapshot: &Snapshot, ray: &Ray, distance: f64, through: Rgb) -> Rgb {
        self.fog.as_ref().map_or(Rgb::ZERO, |fog| fog.before(snapshot, ray, distance, through))
    }

    /// Radiance that fog scatters into any ray, in steps: `is_exact` wants more of them.
    pub fn in_scattered(&self, snapshot: &Snapshot, ray: &Ray, distance: f64, is_exact: bool) -> Rgb {
        const STEPS: u32 = 24;
        const FEW_STEPS: u32 = 6;
        let steps = if is_exact { STEPS } else { FEW_STEPS };
        view::along(&self.solved.field, snapshot, ray, (distance, steps))
    }
}
