//! Contents of a moment, before they are prepared for tracing. In go a moment and mesh trees, out comes a
//! snapshot, or a digest to compare moments. Invariant: moments of one scene with the same digest have the
//! same light everywhere.

use super::mesh_parts::MeshParts;
use super::moment::{Moment, PlacedInstances};
use super::ray_visibility::{casting, rays_of};
use super::{FrozenSky, Luminaire, MeshTrees, Snapshot, View};
use crate::accel::{InstanceTree, SharedTree};
use crate::fog::Medium;
use crate::math::large_list;
use crate::scene::{Hashed, Material, Pose, Scene};
use glam::DVec3;
use sha2::{Digest, Sha256};
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// All contents of a scene at one moment, relative to an origin.
pub struct Contents<'scene> {
    scene: &'scene Scene,
    is_blended: Arc<[bool]>,
    parts: Arc<MeshParts>,
    /// Origin of relative space, in the world.
    origin: DVec3,
    /// Instances with opaque and with blended triangles.
    classes: [PlacedInstances; 2],
    /// Tree of the still ones among the opaque instances, if other moments share it.
    still: Option<SharedTree>,
    materials: Cow<'scene, [Material]>,
    lights: Vec<Luminaire>,
    medium: Medium,
    sky: Option<FrozenSky<'scene>>,
}

impl<'scene> Contents<'scene> {
    /// Contents of a moment, with those of the scene's lights that `lights_on` selects.
    pub(super) fn of(moment: &Moment<'scene, '_>, trees: &MeshTrees, lights_on: &[bool]) -> Self {
        let &Moment { scene, time_s, eye: origin, .. } = moment;
        let medium = moment.medium();
        let lights = moment.lights(lights_on, &medium);
        let classes = moment.instances(trees);
        let [opaque, _] = &classes;
        let still = moment.still.and_then(|still| still.tree(&opaque.meshes[..opaque.still], origin));
        Self {
            scene,
            is_blended: Arc::clone(&trees.is_blended),
            parts: Arc::clone(&trees.parts),
            origin,
            classes,
            still,
            materials: moment.materials(),
            medium: medium.lit_by(&lights.iter().map(|light| light.centre().place()).collect::<Vec<_>>()),
            lights,
            sky: scene.sky.as_ref().and_then(|sky| FrozenSky::new(sky, time_s)),
        }
    }

    /// Contents relative to an origin that does not depend on the camera, for light that does not either.
    pub(super) fn apart_from_camera(
        scene: &'scene Scene,
        trees: &MeshTrees,
        time_s: f64,
        lights_on: &[bool],
    ) -> Self {
        let placements = scene.placements(time_s);
        let instances = scene.instances.iter().map(|instance| instance.node);
        let nodes = instances.chain(scene.fogs.iter().map(|fog| fog.node));
        let visible = nodes.map(|node| &placements[node]).filter(|placement| placement.visible);
        let eye = median(visible.map(|placement| placement.world_from_node.translation));
        let moment = Moment { scene, time_s, frame_s: time_s, placements, eye, still: None };
        Self::of(&moment, trees, lights_on)
    }

    /// Prepares the contents for tracing, relative to their origin.
    pub fn frozen(self) -> Snapshot<'scene> {
        let view = View::at(self.origin);
        self.seen_by(view)
    }

    /// Prepares the contents for tracing; the view's eye is the origin.
    pub(super) fn seen_by(self, view: View) -> Snapshot<'scene> {
        let rays = rays_of(self.scene, &self.classes);
        let casting = casting(&self.classes, rays.as_ref());
        let [mut opaque, blended] = self.classes;
        let first_blended = opaque.placed.len();
        opaque.placed.extend(blended.placed);
        let tree = match self.still {
            Some(still) => {
                let others = opaque.meshes.split_off(opaque.still);
                InstanceTree::beside(still, others)
            }
            None => InstanceTree::new(opaque.meshes),
        };
        let blended_tree = InstanceTree::numbered((first_blended as u32..).zip(blended.meshes));
        let boxes = [tree.bounds(), blended_tree.bounds()].into_iter().flatten();
        Snapshot {
            scene: self.scene,
            view: view.of_surfaces(boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))),
            tree,
            blended: blended_tree,
            casting,
            rays,
            materials: self.materials,
            is_blended: self.is_blended,
            parts: self.parts,
            placed: opaque.placed,
            first_blended,
            lights: self.lights,
            medium: self.medium,
            background: self.scene.background,
            sky: self.sky,
            // A backdrop is part of a file and does not change.
            backdrop: self.scene.backdrop.as_ref().and_then(|backdrop| FrozenSky::new(backdrop, 0.0)),
            middle: Arc::default(),
            motion: None,
            mattes: None,
            seen_fog: OnceLock::new(),
            emissive: OnceLock::new(),
        }
    }

    /// SHA-256 over all that differs from moment to moment.
    pub fn digest(&self) -> [u8; 32] {
        let mut hash = Sha256::new();
        let mut add = |number: f64| hash.update(number.to_le_bytes());
        for class in &self.classes {
            for (placed, mesh) in class.placed.iter().zip(&class.meshes) {
                add(placed.instance() as f64);
                mesh.relative_from_mesh.to_cols_array().into_iter().for_each(&mut add);
                if let Some(bent) = &placed.bent {
                    let Pose { weights, shape_from_rest } = &bent.pose;
                    [weights.len(), shape_from_rest.len()].into_iter().for_each(|count| add(count as f64));
                    weights.iter().copied().for_each(&mut add);
                    let joints = shape_from_rest.iter().flat_map(|joint| joint.to_cols_array());
                    joints.for_each(&mut add);
                }
            }
            add(f64::NAN);
        }
        self.origin.to_array().into_iter().for_each(add);
        let Self { lights, medium, sky, .. } = self;
        let mut hash = Hashed(hash);
        hash.add(format_args!("{lights:?} {medium:?} {:?}", sky.as_ref().map(FrozenSky::turned_by)));
        if let Cow::Owned(materials) = &self.materials {
            hash.add(format_args!("{materials:?}"));
        }
        hash.0.finalize().into()
    }
}

/// Median along each axis, which outliers do not move; the world's origin if there are no places.
fn median(places: impl Iterator<Item = DVec3>) -> DVec3 {
    let finite = places.filter(|place| place.is_finite());
    let mut places: Vec<DVec3> = large_list(finite.size_hint().1.unwrap_or_default());
    places.extend(finite);
    if places.is_empty() {
        return DVec3::ZERO;
    }
    let middle = places.len() / 2;
    let mut of_axis = |axis: usize| {
        let (_, place, _) = places.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
        place[axis]
    };
    DVec3::new(of_axis(0), of_axis(1), of_axis(2))
}
