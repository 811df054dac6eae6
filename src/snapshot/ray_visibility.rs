//! Ray visibility of surfaces. In go flags of the scene's nodes, out come flags by triangle, and trees of
//! shadow casters. Invariant: where all rays meet all surfaces there is one tree for all queries, and no
//! list.

use super::Snapshot;
use super::moment::PlacedInstances;
use crate::accel::{InstanceTree, PrimitiveId};
use crate::scene::{RayVisibility, Scene};
use std::sync::Arc;

/// Ray visibility by the number of an instance.
pub type RaysOfInstances = Arc<[RayVisibility]>;

/// Ray visibility of opaque instances, then of blended ones; `None` if all rays meet all of them.
pub(super) fn rays_of(scene: &Scene, classes: &[PlacedInstances; 2]) -> Option<RaysOfInstances> {
    if scene.ray_visibility.is_empty() {
        return None;
    }
    let placed = classes.iter().flat_map(|class| &class.placed);
    let nodes = placed.map(|placed| scene.instances[placed.instance()].node);
    let rays: RaysOfInstances =
        nodes.map(|node| *scene.ray_visibility.get(&node).unwrap_or(&RayVisibility::USUAL)).collect();
    rays.iter().any(|rays| *rays != RayVisibility::USUAL).then_some(rays)
}

/// Shadow casters among opaque and among blended instances; `None` if all are.
pub(super) fn casting(
    classes: &[PlacedInstances; 2],
    rays: Option<&RaysOfInstances>,
) -> Option<[InstanceTree; 2]> {
    let rays = rays.filter(|rays| rays.iter().any(|rays| !rays.casts_shadow))?;
    let mut first = 0;
    let tree = |class: &PlacedInstances| {
        let numbered = (first..).zip(&class.meshes);
        first += class.meshes.len() as u32;
        let casting = numbered.filter(|(number, _)| rays[*number as usize].casts_shadow);
        InstanceTree::numbered(casting.map(|(number, mesh)| (number, mesh.clone())))
    };
    Some(classes.each_ref().map(tree))
}

impl Snapshot<'_> {
    /// Ray visibility by the number of an instance; `None` if all rays meet all of them.
    pub fn rays_of_instances(&self) -> Option<&RaysOfInstances> {
        self.rays.as_ref()
    }

    /// Whether the camera sees a triangle.
    #[inline]
    pub fn is_seen(&self, primitive: PrimitiveId) -> bool {
        self.rays.as_ref().is_none_or(|rays| rays[primitive.instance as usize].visible_to_camera)
    }

    /// Whether the camera sees a hole in place of a triangle.
    #[inline]
    pub fn is_holdout(&self, primitive: PrimitiveId) -> bool {
        self.rays.as_ref().is_some_and(|rays| rays[primitive.instance as usize].holdout)
    }

    /// Whether a triangle blocks all light: it is opaque and casts shadows.
    #[inline]
    pub fn ends_light(&self, primitive: PrimitiveId) -> bool {
        let casts = self.rays.as_ref().is_none_or(|rays| rays[primitive.instance as usize].casts_shadow);
        casts && (primitive.instance as usize) < self.first_blended
    }

    /// Shadow casters of [`Self::tree`].
    #[inline]
    pub fn casting(&self) -> &InstanceTree {
        self.casting.as_ref().map_or(&self.tree, |[opaque, _]| opaque)
    }

    /// Shadow casters of [`Self::blended`].
    #[inline]
    pub fn casting_blended(&self) -> &InstanceTree {
        self.casting.as_ref().map_or(&self.blended, |[_, blended]| blended)
    }
}
