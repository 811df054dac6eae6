//! Fog. In go fields of a file, out come fog volumes at nodes. Invariant: fog has a box or falls off with
//! height.

use super::{Resolver, track};
use crate::description::ron;
use crate::scene::{Fog, FogShape, HeightFalloff, Motion};
use glam::{DAffine3, DQuat, DVec3};

impl Resolver<'_> {
    pub(super) fn fogs(&mut self) {
        for (name, fog) in self.file.fog.iter() {
            let owner = format!("fog.{name}");
            let mist = fog.mist.as_ref().map(|mist| self.mist(&owner, fog, mist));
            let grids = fog.vdb.as_deref().map(|vdb| self.fog_grids(&owner, fog, vdb));
            if grids.is_none() {
                self.check_no_grids(&owner, fog);
            }
            let (bounds, falloff) = match &grids {
                Some(_) => (None, None),
                None if mist.is_some() => (None, None),
                None => {
                    let bounds = self.fog_bounds(&owner, fog);
                    (bounds, self.fog_falloff(&owner, fog, bounds))
                }
            };
            let parent = self.parent(&owner, fog.parent.as_deref());
            let problems = &mut self.problems;
            let density_per_m = track(&fog.density_per_m, &format!("{owner}.density_per_m"), problems);
            let albedo = track(&fog.albedo, &format!("{owner}.albedo"), problems);
            let anisotropy = track(&fog.anisotropy, &format!("{owner}.anisotropy"), problems);
            let shape = match (bounds, falloff) {
                (None, None) if let Some(Some(mist)) = mist => FogShape::Mist(Box::new(mist)),
                (None, None) if let Some(Some(grids)) = grids => FogShape::Voxels(Box::new(grids)),
                (Some(_), None) => FogShape::EvenBox,
                (Some(_), Some(falloff)) => FogShape::ThinningBox(falloff),
                (None, Some(falloff)) => FogShape::Layer(falloff),
                // Refused already, or below.
                (None, None) => continue,
            };
            let (Some(parent), Some(density_per_m), Some(albedo), Some(anisotropy)) =
                (parent, density_per_m, albedo, anisotropy)
            else {
                continue;
            };
            let parent_from_shape = bounds.map_or(DAffine3::IDENTITY, |[min, max]| {
                let (half_size, centre) = (0.5 * (max - min), 0.5 * (min + max));
                DAffine3::from_scale_rotation_translation(half_size, DQuat::IDENTITY, centre)
            });
            let node = self.scene.add_node(name.to_owned(), parent, Motion::Still(parent_from_shape));
            self.scene.fogs.push(Fog {
                name: name.to_owned(),
                node,
                shape,
                density_per_m,
                albedo,
                anisotropy,
            });
        }
    }

    /// Corners of the box, if there is one.
    pub(super) fn fog_bounds(&mut self, owner: &str, fog: &ron::Fog) -> Option<[DVec3; 2]> {
        match (fog.min_m, fog.max_m) {
            (Some(min), Some(max)) => {
                let (min, max) = (min.si(), max.si());
                if !min.cmplt(max).all() {
                    let found = "the box has no volume";
                    let expected = "min_m < max_m in x, y and z";
                    let remedy = "make the box larger, or exchange its corners";
                    self.problems.error(owner, found, expected, remedy);
                }
                Some([min, max])
            }
            (None, None) if fog.scale_height_m.is_none() => {
                let found = "fog without bounds that is as dense everywhere would absorb all sunlight before it arrives";
                let expected = "`min_m` and `max_m`, or `scale_height_m`, or all three";
                self.problems.error(owner, found, expected, "add `scale_height_m`, or the corners of a box");
                None
            }
            (None, None) => None,
            _ => {
                let expected = "both `min_m` and `max_m`, or neither";
                self.problems.error(owner, "the box has one corner", expected, "add the other corner");
                None
            }
        }
    }

    /// Falloff of the fog with height, if there is one. The default base is the box's bottom.
    fn fog_falloff(
        &mut self,
        owner: &str,
        fog: &ron::Fog,
        bounds: Option<[DVec3; 2]>,
    ) -> Option<HeightFalloff> {
        let Some(scale_height_m) = &fog.scale_height_m else {
            if fog.base_m.is_some() {
                let found = "`base_m` says from where on the fog thins out, but not how fast";
                let remedy = "add `scale_height_m`, or take `base_m` out";
                self.problems.error(owner, found, "`scale_height_m` beside `base_m`", remedy);
            }
            return None;
        };
        let scale_height_m = self.keyed(owner, "scale_height_m", scale_height_m)?;
        let base_m = fog.base_m.map(ron::Number::si);
        let base = match bounds {
            None => base_m.unwrap_or(0.0),
            Some([min, max]) => {
                let (bottom, top) = (min.y, max.y);
                base_m.map_or(-1.0, |base_m| ((base_m - bottom) - (top - base_m)) / (top - bottom))
            }
        };
        Some(HeightFalloff { base, scale_height_m })
    }
}
