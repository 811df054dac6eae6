//! Contents of one grid. In goes a snapshot, out come the medium, the walls, and the first-collision source
//! of its lights. Invariant: each surface is either a wall or leaf area.

use super::wall_light::WallLight;
use super::walls::SnapshotWalls;
use crate::accel::PrimitiveId;
use crate::canopy::delta_scaled_fog::DeltaScaledFog;
use crate::canopy::emissive_bodies::emissive_bodies;
use crate::canopy::first_collisions::{FirstCollisions, Found};
use crate::canopy::fluence::ForwardPeak;
use crate::canopy::leaf_index::LeafIndex;
use crate::canopy::leaf_power::LeafPower;
use crate::canopy::self_interaction::{OwnLight, SelfInteraction};
use crate::canopy::surroundings::Surroundings;
use crate::canopy::turbid_medium::TurbidMedium;
use crate::color::Rgb;
use crate::ordinates::domain::Domain;
use crate::ordinates::emissive_bodies::EmissiveBodies;
use crate::ordinates::first_collision_source::{Emission, FirstCollisionSource};
use crate::ordinates::grid::Grid;
use crate::ordinates::moments::Moments;
use crate::ordinates::occluders::CutGrid;
use crate::ordinates::quadrature::Quadrature;
use crate::scene::Bounces;
use crate::snapshot::{Luminaire, Snapshot};
use std::collections::HashSet;

/// Width in cells from which surfaces are walls.
pub(super) const WALL_CELLS: f64 = 2.0;

/// Share of emissive walls above which sweeps give their light on walls better than sampled points do.
const MOST_EMISSIVE: f64 = 0.1;

/// Input of a solution: snapshot, bounces and leaves.
pub(super) struct Context<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) surroundings: &'a Surroundings<'a>,
    pub(super) leaves: &'a LeafIndex,
    pub(super) bounces: Bounces,
    /// Emissive surfaces as lights, where their direct light on surfaces is not part of the solution.
    pub(super) emissive: Option<Vec<Luminaire>>,
    /// Returns whether to stop; the result is then incomplete.
    pub(super) cancelled: &'a (dyn Fn() -> bool + Sync),
}

/// Medium and walls of a grid.
pub(super) struct Contents<'a> {
    grid: &'a Grid,
    fog: DeltaScaledFog<'a>,
    are_walls: HashSet<PrimitiveId>,
    pub(super) medium: TurbidMedium,
    pub(super) walls: SnapshotWalls,
    /// Small bodies that emit apart from the medium.
    pub(super) bodies: EmissiveBodies,
}

/// Light of lamps and suns at its first collision.
pub(super) struct FirstLight {
    pub(super) source: FirstCollisionSource,
    pub(super) forward_peaks: Vec<ForwardPeak>,
    /// Power that collides again with leaves of the same clump, W m^-3 by node.
    pub(super) met_again: Vec<[f32; 3]>,
    pub(super) on_leaves: LeafPower,
}

impl<'a> Contents<'a> {
    pub(super) fn new(grid: &'a Grid, context: &Context<'a>) -> Self {
        let &Context { snapshot, surroundings, bounces, .. } = context;
        let width_m = WALL_CELLS * grid.cell_m;
        let emit_apart = context.emissive.is_some() && surroundings.has_few_bodies((width_m, grid.cell_m));
        let triangles = surroundings.walls(width_m);
        let fog = DeltaScaledFog::new(&snapshot.medium, snapshot.view.eye, bounces);
        let (walls, surfels) = rayon::join(
            || SnapshotWalls::new(grid, snapshot, &triangles),
            || surroundings.surfels(width_m, grid.cell_m, emit_apart),
        );
        let cut = CutGrid { grid, occluders: &walls.walls.occluders };
        let medium = TurbidMedium::new(cut, &fog, &surfels, bounces);
        let bodies = if emit_apart {
            emissive_bodies(cut, (surroundings, width_m), &medium.clumping)
        } else {
            EmissiveBodies::default()
        };
        let are_walls = triangles.iter().map(|triangle| triangle.primitive).collect();
        Self { grid, fog, are_walls, medium, walls, bodies }
    }

    pub(super) fn domain(&self) -> Domain<'_> {
        let Self { grid, medium, walls, .. } = self;
        Domain { grid, cross_sections: &medium.cross_sections, walls: &walls.walls }
    }

    /// Returns the first-collision source for sweeps along a quadrature.
    pub(super) fn first_light(
        &self,
        context: &Context,
        quadrature: &Quadrature,
        self_interaction: &SelfInteraction,
    ) -> FirstLight {
        let &Context { snapshot, leaves, cancelled, .. } = context;
        let Self { grid, fog, are_walls, medium, walls, .. } = self;
        let cut = CutGrid { grid, occluders: &walls.walls.occluders };
        let collisions = FirstCollisions { snapshot, fog, cut, medium, cancelled, leaves, are_walls };
        let Found { sources, beams, forward_peaks, met_again, on_leaves } = collisions.found();
        let small_emissive = context.emissive.as_ref().filter(|_| self.emissive_share() < MOST_EMISSIVE);
        let emissive = small_emissive.map_or(&[][..], Vec::as_slice);
        let lights = snapshot.lights.as_slice();
        let light = WallLight { snapshot, lights, emissive, grid, fog, walls, quadrature, cancelled };
        let lit = light.found();
        let not_again = |own| self_interaction.all_sent_again(cut, medium, leaves, own);
        let mut sent = walls.walls.reflected_and_through(&lit.irradiances, &lit.through);
        let bright = light.bright(&sent, &lit);
        if let Some(bright) = &bright {
            sent.iter_mut().zip(&bright.radiances).for_each(|(sent, bright)| *sent -= *bright);
        }
        let has_emission = snapshot.emissive().is_some() || snapshot.medium.emits();
        let emission = has_emission.then(|| {
            let is_part = context.emissive.is_none();
            let is_apart = !is_part || context.bounces != Bounces::All;
            let not_again = is_apart.then(|| not_again(OwnLight { on_leaves: None, emitted: true }));
            Emission { not_again, ..self.emission(is_part, small_emissive.is_some()) }
        });
        let own = OwnLight {
            on_leaves: Some(&on_leaves),
            emitted: emission.as_ref().is_some_and(|emission| emission.not_again.is_none()),
        };
        let not_again = (context.bounces != Bounces::UpTo(1)).then(|| not_again(own));
        let source = FirstCollisionSource {
            volume: sources,
            beams,
            walls: sent,
            glossy: lit.glossy,
            not_again,
            emission,
            bright,
        };
        FirstLight { source, forward_peaks, met_again, on_leaves }
    }

    /// Share of emissive patches among all patches of walls.
    fn emissive_share(&self) -> f64 {
        let patches = &self.walls.walls.patches;
        let emitting = patches.iter().filter(|patch| patch.optics.emission != Rgb::ZERO).count();
        emitting as f64 / patches.len().max(1) as f64
    }

    fn emission(&self, is_part: bool, has_lit_walls: bool) -> Emission {
        let mut volume = Moments::zero(self.grid.count());
        self.medium.emit(&mut volume);
        let walls = self.walls.walls.patches.iter().map(|patch| patch.optics.emission).collect();
        Emission { volume, walls, has_lit_walls, is_part, not_again: None }
    }
}
