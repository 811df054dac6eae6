//! Light of all orders of scattering after the first: from leaf to leaf, from sky to ground, within fog. In
//! goes an exposure, out comes an [`Indirect`] for queries of every ray. Invariant: nothing in it is random,
//! and the solution does not depend on the camera.
//!
//! Direct light and single scattering stay exact, in `transport`. Higher orders are solved on world grids by
//! discrete ordinates (Chandrasekhar 1950, "Radiative Transfer"). Leaves and fog together are one turbid
//! medium there. `field.rs` has `ordinates` solve the grids, from the largest inwards: each gets the radiance
//! of the larger one around it (`Level::around`). Beyond all grids, fog over plain ground is a stack of
//! layers (`layers.rs`).

mod bright_patches;
mod contents;
mod cut_patches;
mod extent;
mod field;
mod fog_edges;
mod gathered;
mod ground;
mod highlights;
mod kept;
mod layer_detail;
mod layers;
mod leaf_light;
mod level;
mod lit_square;
mod lobe;
mod sky;
mod solved;
mod stack;
mod towards;
mod view;
mod wall_light;
mod walls;

use self::field::Field;
use self::lobe::Lobe;
use self::solved::Solved;
use self::view::ViewedFog;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::Ray;
use crate::scene::Bounces;
use crate::snapshot::{Exposure, Snapshot, SurfacePoint};
use glam::DVec3;
use std::cell::LazyCell;
use std::f64::consts::FRAC_1_PI;
use std::ops::Range;
use std::sync::Arc;

pub use kept::KeptLight;

/// Indirect light of a shutter interval, with its precomputed view from the camera.
pub struct Indirect {
    solved: Arc<Solved>,
    fog: Option<ViewedFog>,
    /// Light of one bounce less, where that is needed.
    once_less: Option<Box<Self>>,
}

impl Indirect {
    /// Solves indirect light; `None` where nothing can scatter light. Once `cancelled` returns true, the
    /// result is incomplete. `aspect` is width / height of the picture.
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

    /// Light of one scattering less, if there is any.
    pub fn once_less(&self) -> Option<&Self> {
        if self.solved.bounces == Bounces::All { Some(self) } else { self.once_less.as_deref() }
    }

    /// Whether hardly anything absorbs it, so that the series of orders was cut short and is too dark.
    pub fn is_endless(&self) -> bool {
        self.solved.field.levels.iter().any(|level| level.is_endless)
    }

    /// Whether light straight from the sky is part of it, so that rays need not sample it. It is not where a
    /// part of the sky is as bright as a sun, as the shadows of that have edges.
    pub fn has_sky(&self) -> bool {
        self.solved.has_sky
    }

    /// Whether direct light of emissive surfaces on others is part of it, so that rays need not sample it. It
    /// is not where emissive triangles are few enough for rays to sample.
    pub fn has_emission(&self) -> bool {
        self.solved.has_emission
    }

    /// Share of a surface's specular reflection that rays find: harmonics are too blurred for near objects.
    pub fn share_of_rays(point: &SurfacePoint) -> f64 {
        /// Albedo of the coat from hardly visible to visible: in between both methods contribute.
        const SEEN: Range<f64> = 0.05..0.1;
        /// Widths of coats, as glTF's `alpha`: from narrow to as blurred as harmonics are.
        const BLURRED: Range<f64> = 0.1..0.2;
        /// Albedo from which specular reflection dominates, and rays find it at any width.
        const MOST: Range<f64> = 0.3..0.5;
        let share =
            |range: Range<f64>, of: f64| ((of - range.start) / (range.end - range.start)).clamp(0.0, 1.0);
        let cos = point.specular_normal.dot(point.to_eye).max(0.0);
        let of_gloss = point.gloss.as_ref().map(|gloss| (gloss.albedo(cos), gloss.alpha()));
        let of_dielectric =
            point.dielectric.as_ref().map(|own| (own.albedos(cos).iter().sum(), own.alphas()[1]));
        let all = [of_gloss, of_dielectric].into_iter().flatten();
        let (shine, alpha) = all.fold((Rgb::ZERO, 1.0_f64), |all, one| (all.0 + one.0, all.1.min(one.1)));
        let shine = shine.max_element();
        share(SEEN, shine) * (1.0 - share(BLURRED, alpha)).max(share(MOST, shine))
    }

    /// Asks for the light on a leaf, which [`Self::scattered`] will read at a point of the triangle.
    pub fn prefetch(&self, snapshot: &Snapshot, primitive: PrimitiveId) {
        self.solved.leaves.prefetch(snapshot, primitive);
    }

    /// Radiance that a surface scatters towards the eye, W m^-2 sr^-1, with a share of its specular
    /// reflection.
    pub fn scattered(&self, snapshot: &Snapshot, point: &SurfacePoint, share_of_specular: f64) -> Rgb {
        let world = LazyCell::new(|| snapshot.in_the_middle(point));
        let cos_eye = point.specular_normal.dot(point.to_eye).max(0.0);
        let of_dielectric = point.dielectric.as_ref().map_or([Rgb::ZERO; 2], |own| own.albedos(cos_eye));
        let sent = point.albedo + point.transmission + of_dielectric[0] + of_dielectric[1];
        let leaf = self.solved.leaves.of(&self.solved.field, snapshot, point.primitive);
        let gathered = |lobe: Lobe| match &leaf {
            Some(leaf) => leaf.gathered_by(&self.solved.field, &lobe, sent),
            None => self.solved.field.gathered_by(*world, &lobe),
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
        if share_of_specular == 0.0 {
            return radiance;
        }
        let normal = point.specular_normal;
        let mirrored: DVec3 = 2.0 * normal.dot(point.to_eye) * normal - point.to_eye;
        if let Some(gloss) = &point.gloss {
            let lobe = Lobe::glossy(mirrored, normal, gloss.alpha());
            radiance += share_of_specular * FRAC_1_PI * gloss.albedo(cos_eye) * gathered(lobe);
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
            radiance += share_of_specular * FRAC_1_PI * seen;
        }
        radiance
    }

    /// Radiance that fog scatters into a camera ray within `distance` metres. `through` is the transmittance
    /// of that fog.
    pub fn seen_in_fog(&self, snapshot: &Snapshot, ray: &Ray, distance: f64, through: Rgb) -> Rgb {
        self.fog.as_ref().map_or(Rgb::ZERO, |fog| fog.before(snapshot, ray, distance, through))
    }

    /// Radiance that fog scatters into any ray, in steps, of which `is_exact` takes more.
    pub fn in_scattered(&self, snapshot: &Snapshot, ray: &Ray, distance: f64, is_exact: bool) -> Rgb {
        const STEPS: u32 = 24;
        const FEW_STEPS: u32 = 6;
        let steps = if is_exact { STEPS } else { FEW_STEPS };
        view::along(&self.solved.field, snapshot, ray, (distance, steps))
    }
}
