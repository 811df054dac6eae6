//! Solution of indirect light, without a camera. In goes a snapshot, out come a field and the light that
//! leaves gather from it. Invariant: it does not depend on the camera.

use super::contents::Context;
use super::extent::{FEW_LEAVES, LEAVES_PER_CELL, levels};
use super::field::Field;
use super::ground::Beneath;
use super::layers::Layers;
use super::leaf_light::LeafLight;
use super::sky::has_sky;
use crate::canopy::core_bounds::{Strays, Weighed, core_bounds};
use crate::canopy::leaf_index::LeafIndex;
use crate::canopy::surroundings::Surroundings;
use crate::math::bounds;
use crate::scene::Bounces;
use crate::snapshot::Snapshot;
use glam::DVec3;
use std::sync::Arc;

/// Light of all orders after the first.
pub(super) struct Solved {
    pub(super) field: Field,
    pub(super) leaves: LeafLight,
    pub(super) bounces: Bounces,
    pub(super) has_sky: bool,
    /// Whether direct light of emissive surfaces on others is part of it; otherwise rays sample it.
    pub(super) has_emission: bool,
    /// Light of one bounce less, where that is needed.
    pub(super) once_less: Option<Arc<Self>>,
}

impl Solved {
    /// Solves indirect light; `None` where nothing can scatter light. Once `cancelled` returns true, the
    /// result is incomplete.
    pub(super) fn new(
        snapshot: &Snapshot,
        bounces: Bounces,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let mut solved = Self::of_bounces(snapshot, bounces, cancelled)?;
        let emits = snapshot.emissive().is_some() || snapshot.medium.emits();
        if let Bounces::UpTo(count @ 1..) = bounces
            && snapshot.has_gloss()
            && (count > 1 || emits)
        {
            let less = Self::of_bounces(snapshot, Bounces::UpTo(count - 1), cancelled);
            solved.once_less = less.map(Arc::new);
        }
        Some(solved)
    }

    fn of_bounces(
        snapshot: &Snapshot,
        bounces: Bounces,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let mut surroundings = Surroundings::of(snapshot);
        let layers = layers(snapshot, &mut surroundings, bounces);
        let plain_emits = layers.as_ref().is_some_and(|layers| layers.ground_emits);
        // No ray samples the emission of fog.
        let is_swept = plain_emits || snapshot.medium.emits();
        let emissive = snapshot.emissive().filter(|emissive| !is_swept && emissive.is_looked_for());
        let emissive = emissive.map(|emissive| emissive.luminaires(snapshot));
        let has_emission = emissive.is_none();
        let grids = levels(snapshot, &surroundings, layers.as_ref(), emissive.as_deref().unwrap_or_default());
        let cell_m = grids.first().map_or(f64::INFINITY, |grid| grid.cell_m);
        let leaves = LeafIndex::new(snapshot, surroundings.leaves(cell_m));
        let context =
            Context { snapshot, surroundings: &surroundings, leaves: &leaves, bounces, emissive, cancelled };
        let field = Field::on(&grids, layers, &context)?;
        let has_sky = has_sky(snapshot.sky);
        Some(Self { field, leaves: LeafLight::new(leaves), bounces, has_sky, has_emission, once_less: None })
    }
}

/// Layers around all grids, if fog differs with height alone and no hills lie below it. Slabs need a plain.
fn layers(snapshot: &Snapshot, surroundings: &mut Surroundings, bounces: Bounces) -> Option<Layers> {
    let eye = snapshot.view.eye;
    let wide_ground = |width_m: f64| {
        let level = surroundings.wide_parts(width_m, DVec3::Y).into_iter();
        let level = level.map(|part| Weighed { bounds: bounds(part.corners), area_m2: part.area_m2 });
        let (low, high) = core_bounds(level.collect(), Strays::Lost)?;
        Some((low - eye, high - eye))
    };
    let (fog, other_fog) = snapshot.medium.layers_and_rest(&wide_ground);
    let (up, scale_m) = fog.banks().iter().find_map(|bank| bank.layer())?;
    let is_slab = !snapshot.medium.is_unbounded();
    if is_slab && !is_resolved(surroundings, (scale_m, fog.most_ever_per_m())) {
        return None;
    }
    let ground = match Beneath::of(surroundings, up, scale_m) {
        Beneath::Nothing if is_slab => return None,
        Beneath::Hills => return None,
        Beneath::Nothing => None,
        Beneath::Plain(ground) => Some(ground),
    };
    let layers = Layers::new(snapshot, (fog, other_fog), ground.as_ref(), bounces)?;
    // Ground without layers above it belongs to the grids.
    ground.iter().for_each(|ground| surroundings.mark_plain(&ground.parts));
    Some(layers)
}

/// Whether cells for leaves are thin or clear beside a slab of fog, of a height and an extinction: within
/// others, detail of layers is too bright.
fn is_resolved(surroundings: &Surroundings, (height_m, extinction_per_m): (f64, f64)) -> bool {
    /// Maximum height of a cell, as a share of the slab's; or its maximum optical depth.
    const THIN: f64 = 0.25;
    const CLEAR: f64 = 0.2;
    let cell_m = LEAVES_PER_CELL * surroundings.leaf_width_m(height_m, FEW_LEAVES);
    cell_m < THIN * height_m || cell_m * extinction_per_m < CLEAR
}
