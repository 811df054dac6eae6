//! Drifting mist in a node's box: `mist` of `sunfleck_fog_volume`. In go the property and the box, out comes
//! the mist with a node of its own. Invariant: that node has the box's place and no scale, so lengths of the
//! mist are metres.

use super::Builder;
use super::extras;
use crate::math::Recent;
use crate::scene::drift::Drift;
use crate::scene::mist::{FEWEST_VOXELS_A_BILLOW, usual_voxel_m};
use crate::scene::{FogShape, Mist, MistShape, Motion, NodeIndex, Track};
use glam::{DAffine3, DVec3};

/// Maximum speed of the wind, m/s.
const FASTEST_M_PER_S: f64 = 1000.0;

impl Builder<'_> {
    /// Mist in the box of a node, and its own node; `None` if it is refused.
    pub(super) fn mist(
        &mut self,
        fog: &extras::Fog,
        mist: &extras::Mist,
        node: NodeIndex,
        path: &str,
    ) -> Option<(FogShape, NodeIndex)> {
        let path = format!("{path}.mist");
        extras::tell_unknown(&mist.unknown, &mut self.report, |field| format!("{path}.{field}"));
        if fog.vdb.is_some() {
            self.report.error(
                path,
                "`mist` stands beside `vdb`, whose voxels say how dense the fog is",
                "one of the two",
            );
            return None;
        }
        let shape = self.checked_mist(mist, &path)?;
        let half = self.half_size(node);
        if half.min_element() <= 0.0 {
            self.report.error(path, "the mist's box has no volume", "a scale other than 0 along every axis");
            return None;
        }
        let (bounds, octaves) = ([-half, half], mist.octaves.unwrap_or(4));
        let voxel_m = usual_voxel_m(bounds, mist.size, octaves);
        if FEWEST_VOXELS_A_BILLOW * voxel_m > mist.size {
            let found = format!("billows of {} m are too small for a box of {} m", mist.size, 2.0 * half);
            self.report.error(format!("{path}.size"), found, "larger billows, or a smaller box");
            return None;
        }
        let base = fog.base_height.unwrap_or(-1.0);
        let made = Mist {
            bounds,
            shape,
            edge_m: mist.edge.unwrap_or(0.5 * mist.size.min(2.0 * half.min_element())),
            size_m: mist.size,
            octaves,
            cover: Track::from(mist.cover.unwrap_or(0.5)),
            wind: Drift::new(Track::from(DVec3::from(mist.wind.unwrap_or_default()))),
            evolution_turns: Track::from(mist.evolution_turns.unwrap_or(0.0)),
            base_m: base * half.y,
            scale_height_m: fog.scale_height.or(fog.height_falloff.map(f64::recip)).map(Track::from),
            ground: None,
            seed: mist.seed.unwrap_or(0),
            voxel_m,
            kept: Recent::default(),
        };
        let (name, motion) = (self.scene.nodes[node].name.clone(), DAffine3::from_scale(half.recip()));
        let own = self.scene.add_node(name, Some(node), Motion::Still(motion));
        Some((FogShape::Mist(Box::new(made)), own))
    }

    /// Shape of the mist, with its numbers checked against a scene file's ranges.
    fn checked_mist(&mut self, mist: &extras::Mist, path: &str) -> Option<MistShape> {
        let wind = DVec3::from(mist.wind.unwrap_or_default());
        let faults = [
            ("size", mist.size > 0.0 && mist.size.is_finite(), "metres, above 0"),
            ("octaves", matches!(mist.octaves, None | Some(1..=8)), "a whole number from 1 to 8"),
            ("cover", mist.cover.is_none_or(|cover| (0.0..=1.0).contains(&cover)), "a number from 0 to 1"),
            ("wind", wind.length() <= FASTEST_M_PER_S, "m/s along the box's axes, 1000 at most"),
            ("edge", mist.edge.is_none_or(|edge| edge >= 0.0), "metres, at least 0"),
        ];
        for (field, is_right, expected) in faults {
            if !is_right {
                self.report.error(format!("{path}.{field}"), "the number is out of range", expected);
                return None;
            }
        }
        match mist.shape.as_deref() {
            None | Some("box") => Some(MistShape::Box),
            Some("ellipsoid") => Some(MistShape::Ellipsoid),
            Some(other) => {
                let found = format!("`{other}` is no shape of mist");
                self.report.error(format!("{path}.shape"), found, "box or ellipsoid");
                None
            }
        }
    }

    /// Half extents of a node's cube from -1 to 1 at the first frame: metres along its axes.
    fn half_size(&self, mut node: NodeIndex) -> DVec3 {
        let mut world_from_cube = self.scene.nodes[node].motion.parent_from_node(0.0);
        while let Some(parent) = self.scene.nodes[node].parent {
            node = parent;
            world_from_cube = self.scene.nodes[node].motion.parent_from_node(0.0) * world_from_cube;
        }
        let axes = world_from_cube.matrix3;
        DVec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length())
    }
}
