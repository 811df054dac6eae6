//! Tree over placed meshes, and its queries. In go placed meshes, out come hits, shadows and cuts. Invariant:
//! all is in relative space. Instance numbers are positions in the list from which the tree was built, plus
//! the number of shared instances. Still instances may have a tree of their own, shared by the trees of many
//! moments with different origins.

use super::each_shadow::{TriangleShadow, add_each_shadow};
use super::hit::{Hit, PrimitiveId};
use super::instance::{Instance, Instances, PlacedMesh};
use super::level::Level;
use super::light_plane::LightPlane;
use super::ray_query::Trace;
use super::rounding::{round_down, round_up};
use super::shadow_query::AddShadows;
use super::slice_query::{AddCuts, Cut, HalfPlane};
use super::wide_tree::{Bounds, WideTree};
use crate::math::{IntervalSet, Ray, large_list};
use glam::{DAffine3, DVec3, Vec3};
use std::sync::Arc;

/// Tree of all placed meshes of a frame.
#[derive(Debug)]
pub struct InstanceTree {
    shared: Option<SharedTree>,
    tree: WideTree,
    instances: Vec<Instance>,
    /// Index into `instances`, by number; none for instances that nothing can hit.
    positions: Vec<u32>,
    first_number: u32,
    bounds: Option<(DVec3, DVec3)>,
    level: Level,
}

/// Tree of instances that several trees share.
#[derive(Clone, Debug)]
pub struct SharedTree {
    /// The shared tree.
    pub tree: Arc<InstanceTree>,
    /// Number of its instances, and so the first number of the others.
    pub count: u32,
    /// Origin of the sharing tree, in the shared tree's relative space.
    pub origin: DVec3,
}

impl InstanceTree {
    /// Builds the tree; the list may be empty. A mesh with a singular matrix, such as one scaled to zero, is
    /// never hit and casts no shadow.
    pub fn new(placed: Vec<PlacedMesh>) -> Self {
        Self::numbered((0..).zip(placed))
    }

    /// Builds a tree of further instances, besides those of a shared tree.
    pub fn beside(shared: SharedTree, others: Vec<PlacedMesh>) -> Self {
        let mut tree = Self::numbered((shared.count..).zip(others));
        let of_shared = shared.tree.bounds.map(|(low, high)| (low - shared.origin, high - shared.origin));
        let boxes = [of_shared, tree.bounds].into_iter().flatten();
        tree.bounds = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        tree.shared = Some(shared);
        tree
    }

    /// Builds a tree with a given number for each instance.
    pub fn numbered(placed: impl Iterator<Item = (u32, PlacedMesh)>) -> Self {
        Self::with_level(placed, Level::detect())
    }

    fn with_level(placed: impl Iterator<Item = (u32, PlacedMesh)>, level: Level) -> Self {
        // Reserved at once: a million take hundreds of megabytes, and growing would double that.
        let mut instances = large_list(placed.size_hint().1.unwrap_or_default());
        instances.extend(placed.filter_map(|(index, placed)| Instance::new(index, placed)));
        let mut bounds: Option<(DVec3, DVec3)> = None;
        let mut rounded: Vec<Bounds> = large_list(instances.len());
        rounded.extend(instances.iter().map(|instance| {
            let (min, max) = instance.bounds();
            let (low, high) = bounds.unwrap_or((min, max));
            bounds = Some((low.min(min), high.max(max)));
            let min = Vec3::from_array(min.to_array().map(round_down));
            Bounds { min, max: Vec3::from_array(max.to_array().map(round_up)) }
        }));
        let mut order = Vec::with_capacity(instances.len());
        let tree = WideTree::new(&rounded, 1, |instances| {
            order.extend_from_slice(instances);
            order.len() as u32 - 1
        });
        drop(rounded);
        // In the tree's order, and in place, as a million take hundreds of megabytes.
        let mut goes_to = vec![0; instances.len()];
        for (to, &from) in order.iter().enumerate() {
            goes_to[from as usize] = to;
        }
        for at in 0..instances.len() {
            while goes_to[at] != at {
                let to = goes_to[at];
                instances.swap(at, to);
                goes_to.swap(at, to);
            }
        }
        let numbers = || instances.iter().map(|instance| instance.index);
        let first_number = numbers().min().unwrap_or_default();
        let count = numbers().max().map_or(0, |last| last - first_number + 1);
        let mut positions = vec![u32::MAX; count as usize];
        for (number, position) in numbers().zip(0..) {
            positions[(number - first_number) as usize] = position;
        }
        Self { shared: None, tree, instances, positions, first_number, bounds, level }
    }

    /// Nearest hit with `0 < t < t_max` (metres), on either side of a triangle. `skip` is left out: pass the
    /// triangle on which the ray starts.
    pub fn nearest_hit(&self, ray: &Ray, t_max: f64, skip: Option<PrimitiveId>) -> Option<Hit> {
        let of_shared = self.shared.as_ref();
        let of_shared =
            of_shared.and_then(|shared| shared.tree.nearest_hit(&ray.moved(shared.origin), t_max, skip));
        let t_max = of_shared.map_or(t_max, |hit| hit.t);
        self.trace(ray, t_max, skip, false).or(of_shared)
    }

    /// Whether any triangle but `skip` is hit with `0 < t < t_max` (metres).
    pub fn any_hit(&self, ray: &Ray, t_max: f64, skip: Option<PrimitiveId>) -> bool {
        let of_shared = self.shared.as_ref();
        of_shared.is_some_and(|shared| shared.tree.any_hit(&ray.moved(shared.origin), t_max, skip))
            || self.trace(ray, t_max, skip, true).is_some()
    }

    fn trace(&self, ray: &Ray, t_max: f64, skip: Option<PrimitiveId>, any: bool) -> Option<Hit> {
        self.level.run(Trace { instances: self.instances(), ray, t_max, skip, any, nearest: None })
    }

    /// Adds the parts of the plane's ray that lie in the shadow of any mesh. The ray must not cross a
    /// triangle within the range, though it may end on one: a triangle counts as a whole as before or behind
    /// the ray.
    pub fn add_shadows(&self, plane: &LightPlane, shadows: &mut IntervalSet) {
        if let Some(shared) = &self.shared {
            shared.tree.add_shadows(&plane.moved(shared.origin), shadows);
        }
        self.level.run(AddShadows { instances: self.instances(), plane, shadows });
    }

    /// Appends the shadow of each triangle on the plane's ray by itself. The ray may cross triangles.
    pub fn add_each_shadow(&self, plane: &LightPlane, shadows: &mut Vec<TriangleShadow>) {
        if let Some(shared) = &self.shared {
            shared.tree.add_each_shadow(&plane.moved(shared.origin), shadows);
        }
        add_each_shadow(self.instances(), plane, shadows);
    }

    /// Appends the cuts of the half plane, in an order that depends on the tree alone.
    pub fn add_cuts(&self, half_plane: &HalfPlane, cuts: &mut Vec<Cut>) {
        if let Some(shared) = &self.shared {
            let half_plane = HalfPlane { eye: half_plane.eye + shared.origin, ..*half_plane };
            shared.tree.add_cuts(&half_plane, cuts);
        }
        self.level.run(AddCuts { instances: self.instances(), half_plane, cuts });
    }

    /// Whether it has no instances.
    pub fn is_empty(&self) -> bool {
        self.instances.is_empty() && self.shared.as_ref().is_none_or(|shared| shared.tree.is_empty())
    }

    /// Transform of the mesh of a number; the mesh must be one that can be hit.
    pub fn relative_from_mesh(&self, number: u32) -> DAffine3 {
        if let Some(shared) = &self.shared
            && number < shared.count
        {
            let mut relative_from_mesh = shared.tree.relative_from_mesh(number);
            relative_from_mesh.translation -= shared.origin;
            return relative_from_mesh;
        }
        self.instances[self.positions[(number - self.first_number) as usize] as usize].relative_from_mesh
    }

    fn instances(&self) -> Instances<'_> {
        Instances { tree: &self.tree, list: &self.instances }
    }

    /// Corners of the bounds of all instances, in relative space; `None` if there are none.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        self.bounds
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::{mesh_tree::MeshTree, simd::Portable};
    use super::*;
    use crate::math::Sampler;
    use glam::DQuat;
    use std::sync::Arc;

    fn vector(sampler: &mut Sampler) -> DVec3 {
        let ((x, y), z) = (sampler.next_2d(), sampler.next_1d());
        DVec3::new(x, y, z) * 2.0 - 1.0
    }

    /// Hits and shadows are the same to the last bit with any instructions.
    #[test]
    fn instructions_do_not_show() {
        let mut sampler = Sampler::new(1, 0, 0, 0);
        let positions: Vec<Vec3> = (0..900).map(|_| vector(&mut sampler).as_vec3()).collect();
        let triangles: Vec<[u32; 3]> = (0..300).map(|i| [i, (i * 7 + 1) % 900, (i * 5 + 2) % 900]).collect();
        let mesh = Arc::new(MeshTree::new(&positions, &triangles));
        let placed: Vec<PlacedMesh> = (0..40)
            .map(|_| PlacedMesh {
                mesh: mesh.clone(),
                relative_from_mesh: DAffine3::from_scale_rotation_translation(
                    DVec3::new(0.5, 0.3, 0.1),
                    DQuat::from_scaled_axis(3.0 * vector(&mut sampler)),
                    4.0 * vector(&mut sampler),
                ),
            })
            .collect();
        let fast = InstanceTree::new(placed.clone());
        let portable = InstanceTree::with_level((0..).zip(placed), Level::Portable(Portable));
        let (mut hits, mut intervals) = (0, 0);
        for ray in 0..2000 {
            let mut sampler = Sampler::new(2, ray, 0, 0);
            let direction = vector(&mut sampler).normalize();
            // Sometimes along an axis, where slabs divide by 0.
            let direction = if ray % 10 == 0 { DVec3::X } else { direction };
            let ray = Ray { origin: 5.0 * vector(&mut sampler), direction };
            let hit = fast.nearest_hit(&ray, 100.0, None);
            assert_eq!(hit, portable.nearest_hit(&ray, 100.0, None));
            assert_eq!(fast.any_hit(&ray, 2.0, None), portable.any_hit(&ray, 2.0, None));
            hits += usize::from(hit.is_some());
            let range = (0.0, hit.map_or(10.0, |hit| hit.t));
            let light = 6.0 * vector(&mut sampler);
            for plane in [
                LightPlane::towards_direction(&ray, light.normalize(), range).unwrap(),
                LightPlane::towards_point(&ray, light, range).unwrap(),
            ] {
                let (mut a, mut b) = (IntervalSet::default(), IntervalSet::default());
                fast.add_shadows(&plane, &mut a);
                portable.add_shadows(&plane, &mut b);
                assert_eq!(a.as_slice(), b.as_slice());
                intervals += a.as_slice().len();
            }
        }
        assert!(hits > 50 && intervals > 1000, "{hits} {intervals}");
    }

    /// Shared instances are hit as if they were the tree's own.
    #[test]
    fn sharing_does_not_show() {
        let mut sampler = Sampler::new(3, 0, 0, 0);
        let positions: Vec<Vec3> = (0..30).map(|_| vector(&mut sampler).as_vec3()).collect();
        let triangles: Vec<[u32; 3]> = (0..10).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Arc::new(MeshTree::new(&positions, &triangles));
        let place = |_| PlacedMesh {
            mesh: mesh.clone(),
            relative_from_mesh: DAffine3::from_translation(4.0 * vector(&mut sampler)),
        };
        let placed: Vec<PlacedMesh> = (0..40).map(place).collect();
        let (still, others) = placed.split_at(25);
        let alone = InstanceTree::new(placed.clone());
        let beside = |origin: DVec3| {
            let mut still = still.to_vec();
            still.iter_mut().for_each(|placed| placed.relative_from_mesh.translation += origin);
            let shared = SharedTree { tree: Arc::new(InstanceTree::new(still)), count: 25, origin };
            InstanceTree::beside(shared, others.to_vec())
        };
        // With another origin all agree but for the rounding of their boxes and blocks.
        let [beside, moved] = [DVec3::ZERO, DVec3::new(0.5, -0.25, 0.125)].map(beside);
        assert_eq!(beside.bounds(), alone.bounds());
        for number in 0..40 {
            let place = alone.relative_from_mesh(number);
            assert_eq!(beside.relative_from_mesh(number), place);
            assert!(moved.relative_from_mesh(number).abs_diff_eq(place, 1e-12));
        }
        let (mut of_shared, mut shaded_m) = (0, 0.0);
        for number in 0..1000 {
            let mut sampler = Sampler::new(4, number, 0, 0);
            let direction = vector(&mut sampler).normalize();
            let ray = Ray { origin: 5.0 * vector(&mut sampler), direction };
            let hit = alone.nearest_hit(&ray, 100.0, None);
            assert_eq!(beside.nearest_hit(&ray, 100.0, None), hit);
            assert_eq!(beside.any_hit(&ray, 100.0, None), hit.is_some());
            assert_eq!(moved.any_hit(&ray, 100.0, None), hit.is_some());
            let [own, of_moved] = [hit, moved.nearest_hit(&ray, 100.0, None)].map(|hit| hit.map(|hit| hit.t));
            assert!(own.zip(of_moved).is_none_or(|(own, moved)| (own - moved).abs() < 1e-5));
            of_shared += usize::from(hit.is_some_and(|hit| hit.primitive.instance < 25));
            let range = (0.0, hit.map_or(10.0, |hit| hit.t));
            let plane = LightPlane::towards_direction(&ray, vector(&mut sampler).normalize(), range).unwrap();
            let shadows = |tree: &InstanceTree| {
                let mut shadows = IntervalSet::default();
                tree.add_shadows(&plane, &mut shadows);
                shadows.as_slice().to_vec()
            };
            assert_eq!(shadows(&beside), shadows(&alone));
            let metres = |tree| shadows(tree).iter().map(|(start, end)| end - start).sum::<f64>();
            assert!((metres(&moved) - metres(&alone)).abs() < 1e-4);
            shaded_m += metres(&alone);
            let half_plane =
                HalfPlane { eye: ray.origin, axis: DVec3::Y, outward: DVec3::X, lowest_slope: -100.0 };
            let cuts = |tree: &InstanceTree| {
                let mut cuts = Vec::new();
                tree.add_cuts(&half_plane, &mut cuts);
                cuts.sort_by_key(|cut| (cut.primitive.instance, cut.primitive.triangle));
                cuts
            };
            for (moved, own) in cuts(&moved).iter().zip(cuts(&alone)) {
                assert_eq!(moved.primitive, own.primitive);
                assert!(moved.ends.iter().zip(own.ends).all(|(moved, own)| moved.distance(own) < 1e-4));
            }
        }
        assert!(of_shared > 50 && shaded_m > 50.0, "{of_shared} {shaded_m}");
    }
}
