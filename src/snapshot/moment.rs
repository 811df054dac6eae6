//! A scene at one moment, in relative space: instances, fog, lights and materials, as its nodes place them.
//! In go a scene, a time and the eye, out come the parts of a snapshot. Invariant: invisible instances, and
//! those without extent, are left out. Lights stay, switched off, so that all moments of a shutter have the
//! same.

use super::bent_mesh::BentMesh;
use super::still::Still;
use super::{Luminaire, MeshTrees};
use crate::accel::PlacedMesh;
use crate::fog::{Emitter, Falloff, FogBank, Medium};
use crate::math::large_list;
use crate::scene::{Fog, FogShape, GridFrames, HeightFalloff, Light, Material, NodeIndex, Placement, Scene};
use glam::{DAffine3, DVec3};
use std::borrow::Cow;
use std::sync::Arc;

/// Place and time from which a scene is seen.
pub(super) struct Moment<'scene, 'a> {
    pub(super) scene: &'scene Scene,
    pub(super) time_s: f64,
    /// Time of the frame: mist is that in the middle of the shutter.
    pub(super) frame_s: f64,
    /// Placements of its nodes.
    pub(super) placements: Vec<Placement>,
    /// The origin of relative space, in the world.
    pub(super) eye: DVec3,
    /// Instances that are still at this moment and others.
    pub(super) still: Option<&'a Still>,
}

/// An instance of a tree, with its reference to the scene.
pub(super) struct Placed {
    instance: u32,
    mesh: u32,
    /// Bent shape of its mesh, if it bends.
    pub(super) bent: Option<Arc<BentMesh>>,
}

impl Placed {
    /// Number of the scene's instance.
    pub(super) fn instance(&self) -> usize {
        self.instance as usize
    }

    pub(super) fn mesh(&self) -> usize {
        self.mesh as usize
    }
}

/// Instances that rays can meet, and their placed meshes for the tree, in the same order.
#[derive(Default)]
pub(super) struct PlacedInstances {
    pub(super) placed: Vec<Placed>,
    pub(super) meshes: Vec<PlacedMesh>,
    /// Number of leading instances that are still at other moments, too.
    pub(super) still: usize,
}

impl<'scene> Moment<'scene, '_> {
    fn relative_from(&self, node: NodeIndex) -> DAffine3 {
        self.relative(self.placements[node].world_from_node)
    }

    fn relative(&self, mut world_from: DAffine3) -> DAffine3 {
        world_from.translation -= self.eye;
        world_from
    }

    /// The visible instances of opaque and of blended triangles.
    pub(super) fn instances(&self, trees: &MeshTrees) -> [PlacedInstances; 2] {
        let [mut still, mut opaque, mut blended] = [(); 3].map(|()| PlacedInstances::default());
        if self.still.is_none() {
            opaque.placed.reserve_exact(self.scene.instances.len());
            opaque.meshes = large_list(self.scene.instances.len());
        }
        for (index, instance) in self.scene.instances.iter().enumerate() {
            if !self.placements[instance.node].visible {
                continue;
            }
            let (bent, relative_from_mesh) = match &instance.deformation {
                None => (None, self.relative_from(instance.node)),
                Some(deformation) => {
                    let (pose, shape) = deformation.pose(&self.placements, instance.node, self.time_s);
                    let bent = trees.bent(self.scene, (index, instance), deformation, pose);
                    (Some(bent), self.relative(shape))
                }
            };
            let own = bent.as_ref().map(|bent| bent.trees.clone());
            let own = own.unwrap_or_else(|| trees.of(self.scene, instance));
            let keeps_still = self.still.is_some_and(|still| still.keeps(index));
            let classes = [if keeps_still { &mut still } else { &mut opaque }, &mut blended];
            for (class, mesh) in classes.into_iter().zip(own) {
                let Some(mesh) = mesh else { continue };
                let mesh = PlacedMesh { mesh, relative_from_mesh };
                // A leaf scaled to zero is left out.
                if mesh.mesh_from_relative().is_some() {
                    let [index, mesh_number] = [index, instance.mesh].map(|number| number as u32);
                    class.placed.push(Placed { instance: index, mesh: mesh_number, bent: bent.clone() });
                    class.meshes.push(mesh);
                }
            }
        }
        if still.placed.is_empty() {
            return [opaque, blended];
        }
        still.still = still.placed.len();
        still.placed.append(&mut opaque.placed);
        still.meshes.append(&mut opaque.meshes);
        [still, blended]
    }

    pub(super) fn medium(&self) -> Medium {
        let (mut banks, mut emitters) = (Vec::new(), Vec::new());
        for fog in self.scene.fogs.iter().filter(|fog| self.placements[fog.node].visible) {
            let first = banks.len();
            match &fog.shape {
                FogShape::Voxels(grids) => self.add_grids(fog, grids, &mut banks, &mut emitters),
                _ => banks.extend(self.fog_bank(fog)),
            }
            for bank in &mut banks[first..] {
                (bank.densest, bank.stays) = (fog.densest(self.time_s), self.scene.stays(fog.node));
            }
        }
        Medium::new(banks).with_emitters(emitters)
    }

    /// Adds fog from the grids of files, and its emission.
    fn add_grids(
        &self,
        fog: &Fog,
        grids: &GridFrames,
        banks: &mut Vec<FogBank>,
        emitters: &mut Vec<Emitter>,
    ) {
        let time_s = self.time_s;
        // Advected voxels are computed anew for each time: once a frame.
        let voxels_s = if grids.is_carried() { self.frame_s } else { time_s };
        let Some(voxels) = grids.at(voxels_s) else { return };
        let (sigma_t, albedo) = (fog.density_per_m.at(time_s), fog.albedo.at(time_s));
        let (g, relative_from_node) = (fog.anisotropy.at(time_s), self.relative_from(fog.node));
        let relative_from_voxel = relative_from_node * voxels.shape_from_voxel;
        banks.extend(voxels.parts.iter().filter_map(|part| {
            let (sigma_t, albedo) = (sigma_t * part.extinction, albedo * part.albedo);
            FogBank::of_voxels(relative_from_voxel, Arc::clone(&part.voxels), sigma_t, albedo, g)
        }));
        let relative_from_emission = relative_from_node * voxels.shape_from_emission;
        let emission = grids.emission.at(time_s);
        emitters.extend(voxels.emission.iter().filter_map(|(color, voxels)| {
            Emitter::new(relative_from_emission, Arc::clone(voxels), emission * *color)
        }));
    }

    /// Bank of a fog; `None` if it has no effect.
    fn fog_bank(&self, fog: &Fog) -> Option<FogBank> {
        let (relative_from_node, time_s) = (self.relative_from(fog.node), self.time_s);
        let (sigma_t, albedo) = (fog.density_per_m.at(time_s), fog.albedo.at(time_s));
        let g = fog.anisotropy.at(time_s);
        let frozen = |falloff: &HeightFalloff| {
            Falloff::new(relative_from_node, falloff.base, falloff.scale_height_m.at(time_s))
        };
        match &fog.shape {
            FogShape::EvenBox => FogBank::in_box(relative_from_node, sigma_t, albedo, g),
            FogShape::ThinningBox(falloff) => {
                Some(FogBank::in_box(relative_from_node, sigma_t, albedo, g)?.thinning(frozen(falloff)?))
            }
            FogShape::Layer(falloff) => FogBank::everywhere(frozen(falloff)?, sigma_t, albedo, g),
            // There may be several, see `add_grids`.
            FogShape::Voxels(_) => None,
            FogShape::Mist(mist) => {
                let shape_from_voxel = DAffine3::from_scale(DVec3::splat(mist.voxel_m));
                let voxels = mist.voxels(self.frame_s)?;
                FogBank::of_voxels(relative_from_node * shape_from_voxel, voxels, sigma_t, albedo, g)
            }
        }
    }

    /// Lights that `lights_on` selects, suns of the sky last.
    pub(super) fn lights(&self, lights_on: &[bool], medium: &Medium) -> Vec<Luminaire> {
        let of_sky = self.scene.sky.iter().flat_map(|sky| sky.suns_at(self.time_s));
        let of_sky = of_sky.zip(&lights_on[self.scene.lights.len()..]).filter(|(_, is_on)| **is_on);
        let of_sky = of_sky.map(|(sun, _)| Luminaire::of_sky(&sun));
        let lights_on = self.scene.lights.iter().zip(lights_on).filter(|(_, is_on)| **is_on);
        let luminaire = |(light, _): (&Light, _)| {
            let relative_from_light = self.relative_from(light.node);
            let extinction_per_m = medium.extinction_at(relative_from_light.translation);
            let traits = self.scene.lamp_traits.get(&light.node).copied().unwrap_or_default();
            let luminaire = Luminaire::new(light, relative_from_light, self.time_s).with(traits);
            let luminaire = luminaire.in_fog(extinction_per_m);
            if self.placements[light.node].visible { luminaire } else { luminaire.switched_off() }
        };
        lights_on.map(luminaire).chain(of_sky).collect()
    }

    pub(super) fn materials(&self) -> Cow<'scene, [Material]> {
        let materials = self.scene.materials.as_slice();
        if materials.iter().all(Material::is_constant) {
            Cow::Borrowed(materials)
        } else {
            materials.iter().map(|material| material.at(self.time_s)).collect()
        }
    }
}

/// Whether each of a scene's lights emits, and then each sun of its sky.
pub(super) fn lights_on(scene: &Scene, time_s: f64) -> Vec<bool> {
    let is_on =
        |light: &Light| light.power.at(time_s).max_element() > 0.0 && scene.is_visible(light.node, time_s);
    let suns = scene.sky.iter().flat_map(|sky| sky.suns_at(time_s));
    let of_sky = suns.map(|sun| sun.irradiance.max_element() > 0.0);
    scene.lights.iter().map(is_on).chain(of_sky).collect()
}
