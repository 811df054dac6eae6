//! Mist. In go fields of a file, out comes drifting mist in a box. Invariant: it has a box, and at most the
//! maximum number of voxels.

use super::{Resolver, track};
use crate::description::ron;
use crate::math::Recent;
use crate::scene::drift::Drift;
use crate::scene::mist::{FEWEST_VOXELS_A_BILLOW, usual_voxel_m, voxel_count};
use crate::scene::{GroundHeights, MOST_MIST_VOXELS, Mist};
use glam::DVec3;
use std::sync::Arc;

/// Default width over which mist fades, relative to the largest billows and, as a maximum, to the box's
/// shortest side.
const USUAL_EDGE: f64 = 0.5;
/// Maximum coordinates in voxels, well within 32-bit integers.
const FARTHEST_VOXELS: f64 = 1e9;

impl Resolver<'_> {
    /// Mist of a fog volume; `None` if it is refused.
    pub(super) fn mist(&mut self, owner: &str, fog: &ron::Fog, mist: &ron::Mist) -> Option<Mist> {
        let bounds = self.mist_bounds(owner, fog)?;
        let size_m = mist.size_m.si();
        let usual_m = usual_voxel_m(bounds, size_m, mist.octaves.get());
        let voxel_m = mist.voxel_m.map_or(usual_m, ron::Number::si);
        self.check_mist_voxels(owner, bounds, (size_m, voxel_m))?;
        let shortest_m = (bounds[1] - bounds[0]).min_element();
        let ground = match &mist.ground {
            Some(name) => Some(Arc::new(self.mist_ground(owner, fog, name, (bounds, voxel_m))?)),
            None => None,
        };
        let problems = &mut self.problems;
        let field = |name: &str| format!("{owner}.mist.{name}");
        let cover = track(&mist.cover, &field("cover"), problems);
        let wind = track(&mist.wind_m_per_s, &field("wind_m_per_s"), problems);
        let evolution_turns = track(&mist.evolution_turns, &field("evolution_turns"), problems);
        let scale_height_m = match &fog.scale_height_m {
            Some(height) => Some(track(height, &format!("{owner}.scale_height_m"), problems)?),
            None => None,
        };
        Some(Mist {
            bounds,
            shape: mist.shape,
            edge_m: mist.edge_m.map_or(USUAL_EDGE * size_m.min(shortest_m), ron::Number::si),
            size_m,
            octaves: mist.octaves.get(),
            cover: cover?,
            wind: Drift::new(wind?),
            evolution_turns: evolution_turns?,
            base_m: fog.base_m.map_or(bounds[0].y, ron::Number::si),
            scale_height_m,
            ground,
            seed: mist.seed,
            voxel_m,
            kept: Recent::default(),
        })
    }

    /// Checks the maximum number of voxels, and the minimum that billows need.
    fn check_mist_voxels(
        &mut self,
        owner: &str,
        bounds: [DVec3; 2],
        (size_m, voxel_m): (f64, f64),
    ) -> Option<()> {
        let count = voxel_count(bounds, voxel_m);
        let farthest =
            bounds.map(|corner| corner.abs().max_element()).into_iter().fold(0.0, f64::max) / voxel_m;
        let widest_m = size_m / FEWEST_VOXELS_A_BILLOW;
        let (found, expected, remedy) = if count > MOST_MIST_VOXELS {
            let found = format!("mist with a voxel every {voxel_m} m has {count:.0} of them");
            let expected = format!("{MOST_MIST_VOXELS:.0} at most");
            (found, expected, "make `voxel_m` larger, or the box smaller")
        } else if voxel_m > widest_m {
            let found = format!("mist with a voxel every {voxel_m} m has billows of {size_m} m");
            let expected = format!("a voxel every {widest_m} m at most");
            (found, expected, "make `size_m` larger, or the box or `voxel_m` smaller")
        } else if farthest > FARTHEST_VOXELS {
            let found = format!("mist lies {farthest:.0} voxels from its parent's origin");
            let expected = format!("{FARTHEST_VOXELS:.0} at most");
            (found, expected, "give it a `parent` that is nearer to it, or make `voxel_m` larger")
        } else {
            return Some(());
        };
        self.problems.error(&format!("{owner}.mist"), &found, &expected, remedy);
        None
    }

    fn mist_bounds(&mut self, owner: &str, fog: &ron::Fog) -> Option<[DVec3; 2]> {
        if fog.vdb.is_some() {
            let found = "`mist` stands beside `vdb`, whose voxels say how dense the fog is";
            self.problems.error(owner, found, "one of the two", "take one out, or add a bank of fog");
            return None;
        }
        if fog.min_m.is_none() && fog.max_m.is_none() {
            let found = "`mist` has no box";
            self.problems.error(owner, found, "`min_m` and `max_m`", "add the corners of a box");
            return None;
        }
        self.fog_bounds(owner, fog)
    }

    fn mist_ground(
        &mut self,
        owner: &str,
        fog: &ron::Fog,
        name: &str,
        (bounds, voxel_m): ([DVec3; 2], f64),
    ) -> Option<GroundHeights> {
        let field = format!("{owner}.mist.ground");
        if fog.parent.is_some() {
            let found = "mist with a `parent` has a ground, which stays where it is";
            self.problems.error(&field, found, "one of the two", "take `parent` or `ground` out");
            return None;
        }
        let triangles = self.still_triangles(&field, name)?;
        Some(GroundHeights::new(bounds, voxel_m, &triangles))
    }
}
