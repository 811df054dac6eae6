//! Animated OBJ sequences. In go models, out come meshes with a morph target a frame, whose weight is 1 at
//! its frame and 0 at adjacent ones. Invariant: vertices move linearly between frames, and rest before the
//! first and after the last, as in baked glTF deformations. Different faces are another mesh.

use super::{Deformation, FrameRate, MeshIndex, Motion, NodeIndex, Resolver};
use crate::description::obj::ObjModel;
use crate::description::ron::{Named, Replacement};
use crate::description::tangents::{self, Vertices};
use crate::scene::outline::Between;
use crate::scene::{Extend, InnerVertex, Key, MorphTarget, Segment, Track};
use glam::{Vec3, Vec4};
use std::path::Path;
use std::sync::Arc;

/// Mesh from a time on; `None` if there are no triangles then.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    from_s: f64,
    mesh: Option<MeshIndex>,
}

/// Deformation of a model's mesh; `None` if it is constant.
fn deformation(model: &ObjModel, rate: FrameRate) -> Option<Deformation> {
    let shapes = &model.shapes;
    let last = shapes.after.len();
    let key = |step: usize, value: f64| Key {
        time_s: rate.seconds(shapes.first_frame as f64 + step as f64),
        value,
        to_next: Segment::Linear,
    };
    let weight = |step: usize| {
        let after = (step < last).then(|| key(step + 1, 0.0));
        Track::new([key(step - 1, 0.0), key(step, 1.0)].into_iter().chain(after).collect(), Extend::Hold)
    };
    let weights: Option<Vec<Track<f64>>> = (1..=last).map(weight).collect();
    let targets = shapes.after.iter().map(|shape| MorphTarget {
        positions: differences(&shape.positions, &model.positions),
        normals: differences(&shape.normals, &model.normals),
        tangents: Vec::new(),
    });
    let (targets, inner) = (targets.collect(), [].into());
    (last > 0).then_some(Deformation { targets, weights: weights?, skin: None, inner })
}

fn differences(values: &[Vec3], from: &[Vec3]) -> Vec<Vec3> {
    values.iter().zip(from).map(|(value, from)| *value - *from).collect()
}

impl<'a> Resolver<'a> {
    /// Mesh of an OBJ file; for a sequence the first of its meshes.
    pub(super) fn model_meshes(
        &mut self,
        name: &'a str,
        path: &'a Path,
        replaced: Option<&'a Named<Replacement>>,
    ) -> Option<MeshIndex> {
        let model = self.models.get(path)?;
        let mut turns = Vec::new();
        for (number, model) in std::iter::once(model).chain(&model.later).enumerate() {
            let from_s = self.frame_rate.seconds(model.shapes.first_frame as f64);
            let mut turn = Turn { from_s, mesh: None };
            if !model.triangles.is_empty() {
                let mesh = self.model_mesh(name, (path, number), model, replaced)?;
                let index = self.scene.meshes.len();
                let moving = deformation(model, self.frame_rate);
                self.moving.extend(moving.map(|moving| (index, Arc::new(moving))));
                self.scene.meshes.push(mesh);
                turn.mesh = Some(index);
            }
            turns.push(turn);
        }
        let first = turns.iter().find_map(|turn| turn.mesh)?;
        if turns.len() > 1 {
            self.turns.insert(first, turns.into());
        }
        Some(first)
    }

    /// Calls `place` for each mesh of a sequence, below a node that is visible at its time; returns false if
    /// `mesh` is the only one.
    pub(super) fn in_turns(
        &mut self,
        node: NodeIndex,
        mesh: MeshIndex,
        mut place: impl FnMut(&mut Self, NodeIndex, MeshIndex),
    ) -> bool {
        let Some(turns) = self.turns.get(&mesh).cloned() else { return false };
        for (number, turn) in turns.iter().enumerate() {
            let Some(mesh) = turn.mesh else { continue };
            let key = |time_s: f64, value: bool| Key { time_s, value, to_next: Segment::Step };
            let before = (number > 0).then(|| [key(turn.from_s - 1.0, false), key(turn.from_s, true)]);
            let after = turns.get(number + 1).map(|next| match number {
                0 => vec![key(next.from_s - 1.0, true), key(next.from_s, false)],
                _ => vec![key(next.from_s, false)],
            });
            let keys = before.into_iter().flatten().chain(after.into_iter().flatten()).collect();
            let child = self.scene.add_node(self.scene.nodes[node].name.clone(), Some(node), Motion::STILL);
            if let Some(visible) = Track::new(keys, Extend::Hold) {
                self.scene.nodes[child].visible = visible;
            }
            if let Some(&rays) = self.scene.ray_visibility.get(&node) {
                self.scene.set_ray_visibility(child, rays);
            }
            place(self, child, mesh);
        }
        true
    }

    /// Reports a changing mesh of an object where only a constant one is allowed; returns false if it is
    /// constant.
    pub(super) fn changes_shape(&mut self, field: &str, object: &str) -> bool {
        let mesh = self.file.objects.get(object).and_then(|object| object.mesh.as_deref());
        let mesh = mesh.and_then(|mesh| self.meshes.get(mesh));
        let changes =
            mesh.is_some_and(|mesh| self.moving.contains_key(mesh) || self.turns.contains_key(mesh));
        if changes {
            let found = format!("the mesh of `{object}` changes its shape");
            let remedy = "name an object whose mesh is a single file";
            self.problems.error(field, found, "a mesh that keeps its shape", remedy);
        }
        changes
    }

    /// Gives a cut mesh the deformation of its original, with new vertices after the old ones.
    pub(super) fn bend_like(&mut self, mesh: MeshIndex, cut: MeshIndex, added: &[Between]) {
        let Some(whole) = self.moving.get(&mesh) else { return };
        let first = self.scene.meshes[mesh].positions.len() as u32;
        let inner = (first..).zip(added).map(|(vertex, between)| InnerVertex {
            vertex,
            corners: between.corners,
            weights: between.weights,
        });
        let moving = Deformation { inner: inner.collect(), ..Deformation::clone(whole) };
        self.moving.insert(cut, Arc::new(moving));
    }

    /// Adds tangents to the targets of a mesh that got tangents, and values for its duplicated vertices.
    pub(super) fn bend_tangents(&mut self, index: MeshIndex, made: &tangents::Tangents) {
        let Some(moving) = self.moving.get_mut(&index) else { return };
        let mesh = &self.scene.meshes[index];
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|triangle| triangle.vertices).collect();
        let mut bent = Deformation::clone(moving);
        let mut targets = bent.targets.to_vec();
        for target in &mut targets {
            made.copy(&mut target.positions);
            made.copy(&mut target.normals);
            let positions = sums(&mesh.positions, &target.positions);
            let normals = sums(&mesh.normals, &target.normals);
            let vertices = Vertices { positions: &positions, normals: &normals, uvs: &mesh.uvs };
            if let Some(made) = tangents::generate(vertices, &mut triangles.clone()) {
                let truncated: Vec<Vec3> = made.tangents.iter().copied().map(Vec4::truncate).collect();
                let rest: Vec<Vec3> = mesh.tangents.iter().copied().map(Vec4::truncate).collect();
                target.tangents = differences(&truncated, &rest);
            }
        }
        bent.targets = targets.into();
        *moving = Arc::new(bent);
    }
}

fn sums(values: &[Vec3], more: &[Vec3]) -> Vec<Vec3> {
    values.iter().zip(more).map(|(value, more)| *value + *more).collect()
}
