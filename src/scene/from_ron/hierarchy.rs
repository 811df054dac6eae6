//! Hierarchy of objects. In go objects in any order, out come nodes, parents first. Invariant: no object is
//! its own ancestor.

use super::{Resolver, rotation, track};
use crate::description::ron::{Animated, Object};
use crate::scene::{MeshIndex, Motion, Node, NodeIndex, RayVisibility, Rotation, Track};
use glam::DAffine3;
use std::collections::BTreeMap;

impl<'a> Resolver<'a> {
    pub(super) fn objects(&mut self) {
        let objects: BTreeMap<&'a str, &'a Object> = self.file.objects.iter().collect();
        for (name, _) in self.file.objects.iter() {
            for (name, object) in self.ancestors_first(name, &objects) {
                self.object(name, object);
            }
        }
    }

    /// The object and its unplaced ancestors, topmost first.
    fn ancestors_first(
        &mut self,
        name: &'a str,
        objects: &BTreeMap<&'a str, &'a Object>,
    ) -> Vec<(&'a str, &'a Object)> {
        let mut chain: Vec<(&'a str, &'a Object)> = Vec::new();
        let mut in_chain = BTreeMap::new();
        let mut next = Some(name);
        while let Some(name) = next.filter(|name| !self.nodes.contains_key(name)) {
            let owner = format!("objects.{}", chain.last().map_or(name, |(child, _)| child));
            if let Some(&start) = in_chain.get(name) {
                let mut cycle: Vec<_> = chain[start..].iter().map(|(name, _)| format!("`{name}`")).collect();
                cycle.push(format!("`{name}`"));
                let found = format!("the object follows itself: {}", cycle.join(" follows "));
                let remedy = "take one of these parents out";
                self.problems.error(&format!("{owner}.parent"), found, "parents without a circle", remedy);
                break;
            }
            let Some(object) = self.problems.find(&format!("{owner}.parent"), "object", name, objects) else {
                break;
            };
            in_chain.insert(name, chain.len());
            chain.push((name, object));
            next = object.parent.as_deref();
        }
        chain.reverse();
        chain
    }

    fn object(&mut self, name: &'a str, object: &'a Object) {
        let owner = format!("objects.{name}");
        let motion = self.object_motion(&owner, object).unwrap_or(Motion::STILL);
        let visible = self.visibility(&owner, &object.visible);
        // A missing or cyclic parent is reported already.
        let parent: Option<NodeIndex> =
            object.parent.as_deref().and_then(|parent| self.nodes.get(parent)).copied();
        let mesh = object.mesh.as_deref().and_then(|mesh| self.seen_mesh(&owner, object, mesh));
        let material = object.material.as_deref();
        let material = material.and_then(|name| self.material(&format!("{owner}.material"), name));
        if object.mesh.is_none() && object.material.is_some() {
            let found = "there is a material but no mesh";
            let remedy = "name a mesh of `meshes`, or take the material out";
            self.problems.error(&format!("{owner}.material"), found, "a mesh beside the material", remedy);
        }
        let node = self.scene.nodes.len();
        self.nodes.insert(name, node);
        self.scene.nodes.push(Node { name: name.to_owned(), parent, motion, visible });
        let Object { visible_to_camera, casts_shadow, holdout, .. } = *object;
        let rays = RayVisibility { visible_to_camera, casts_shadow, holdout };
        self.scene.set_ray_visibility(node, rays);
        if let Some(mesh) = mesh {
            self.instance(node, mesh, material);
        }
    }

    fn seen_mesh(&mut self, owner: &str, object: &Object, mesh: &str) -> Option<MeshIndex> {
        let field = format!("{owner}.mesh");
        if object.visible == Animated::Still(false) {
            // Meshes of invisible objects were not read.
            self.problems.find(&field, "mesh", mesh, &self.mesh_files);
            return None;
        }
        self.mesh(&field, mesh)
    }

    fn object_motion(&mut self, owner: &str, object: &Object) -> Option<Motion> {
        let problems = &mut self.problems;
        let translation = track(&object.translation_m, &format!("{owner}.translation_m"), problems);
        let turn =
            rotation(object.rotation_deg.as_ref(), object.rotation_quaternion.as_ref(), owner, problems);
        let scale = track(&object.scale, &format!("{owner}.scale"), problems);
        let (translation, rotation, scale) = (translation?, turn?, scale?);
        let turns = match &rotation {
            Rotation::Quaternion(track) => !track.is_constant(),
            Rotation::EulerXyz(track) => !track.is_constant(),
        };
        if translation.is_constant() && !turns && scale.is_constant() {
            let parent_from_node = DAffine3::from_scale_rotation_translation(
                scale.at(0.0),
                rotation.at(0.0),
                translation.at(0.0),
            );
            return Some(Motion::Still(parent_from_node));
        }
        Some(Motion::Keyed { translation, rotation, scale })
    }

    fn visibility(&mut self, owner: &str, visible: &Animated<bool>) -> Track<bool> {
        self.keyed(owner, "visible", visible).unwrap_or_else(|| Track::from(true))
    }
}
