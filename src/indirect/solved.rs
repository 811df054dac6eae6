//! Solution of indirect light, without a camera. In goes a snapshot, out come a field and the light that
//! leaves gather from it. Invariant: it does not depend on the camera.

use super::contents::Context;
use super::extent::levels;
use super::field::Field;
use super::ground::Beneath;
use super::layers::Layers;
use super::leaf_light::LeafLight;
use super::sky::has_sky;
use crate::canopy::leaf_index::LeafIndex;
use crate::canopy::surroundings::Surroundings;
use crate::scene::Bounces;
use crate::snapshot::Snapshot;
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

/// Layers around all grids, if there is unbounded fog and no hills lie below it.
fn layers(snapshot: &Snapshot, surroundings: &mut Surroundings, bounces: Bounces) -> Option<Layers> {
    let (up, scale_m) = snapshot.medium.banks().iter().find_map(|bank| bank.layer())?;
    let ground = match Beneath::of(surroundings, up, scale_m) {
        Beneath::Hills => return None,
        Beneath::Nothing => None,
        Beneath::Plain(ground) => Some(ground),
    };
    Layers::new(snapshot, ground.as_ref(), bounces)
}
