//! Acceleration structures against brute force in double precision, written another way.

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3};
use std::sync::Arc;
use sunfleck::accel::{InstanceTree, LightPlane, MeshTree, PlacedMesh, PrimitiveId};
use sunfleck::math::{IntervalSet, Ray};

/// SplitMix64 (Steele et al. 2014).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    fn in_cube(&mut self, half: f64) -> DVec3 {
        DVec3::new(self.between(-half, half), self.between(-half, half), self.between(-half, half))
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.in_cube(1.0);
            if v.length_squared() > 0.01 && v.length_squared() < 1.0 {
                return v.normalize();
            }
        }
    }

    fn rotation(&mut self) -> DQuat {
        DQuat::from_axis_angle(self.direction(), self.between(0.0, 6.3))
    }
}

type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

fn soup(random: &mut Random, count: usize, half: f64, size: f64) -> Mesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let centre = random.in_cube(half);
        positions.extend((0..3).map(|_| (centre + random.in_cube(size)).as_vec3()));
    }
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    (positions, triangles)
}

/// Meshes and their placements, and the same as plain triangles.
struct Scene {
    tree: InstanceTree,
    triangles: Vec<(PrimitiveId, [DVec3; 3])>,
}

impl Scene {
    fn new(meshes: &[Mesh], placements: &[(usize, DAffine3)]) -> Self {
        let trees: Vec<Arc<MeshTree>> = meshes
            .iter()
            .map(|(positions, triangles)| Arc::new(MeshTree::new(positions, triangles)))
            .collect();
        let placed = placements
            .iter()
            .map(|(mesh, placement)| PlacedMesh {
                mesh: trees[*mesh].clone(),
                relative_from_mesh: *placement,
            })
            .collect();
        let mut triangles = Vec::new();
        for (instance, (mesh, placement)) in placements.iter().enumerate() {
            for (triangle, indices) in meshes[*mesh].1.iter().enumerate() {
                let id = PrimitiveId { instance: instance as u32, triangle: triangle as u32 };
                let corners =
                    indices.map(|i| placement.transform_point3(meshes[*mesh].0[i as usize].as_dvec3()));
                triangles.push((id, corners));
            }
        }
        Self { tree: InstanceTree::new(placed), triangles }
    }

    fn one(mesh: Mesh) -> Self {
        Self::new(&[mesh], &[(0, DAffine3::IDENTITY)])
    }

    /// 60 differently scaled, sheared and mirrored copies of three soups.
    fn instanced(random: &mut Random, offset: DVec3) -> Self {
        let meshes: Vec<Mesh> = [3, 20, 200].map(|count| soup(random, count, 1.0, 0.4)).into();
        let placements: Vec<(usize, DAffine3)> = (0..60)
            .map(|i| {
                let scale = DVec3::new(
                    random.between(0.2, 1.5),
                    random.between(-1.5, -0.2),
                    random.between(0.01, 1.0),
                );
                let affine = DAffine3::from_quat(random.rotation())
                    * DAffine3::from_scale(scale)
                    * DAffine3::from_quat(random.rotation());
                let at = random.in_cube(5.0) + offset;
                (i % 3, DAffine3::from_translation(at) * affine)
            })
            .collect();
        Self::new(&meshes, &placements)
    }

    /// Badouel's way: cut the triangle's plane, then compare areas.
    fn brute_force_hit(&self, ray: &Ray, skip: Option<PrimitiveId>) -> Option<(f64, PrimitiveId)> {
        let mut nearest: Option<(f64, PrimitiveId)> = None;
        for (id, [a, b, c]) in &self.triangles {
            if Some(*id) == skip {
                continue;
            }
            let normal = (*b - *a).cross(*c - *a);
            let t = normal.dot(*a - ray.origin) / normal.dot(ray.direction);
            if !(t > 0.0 && nearest.is_none_or(|(nearest, _)| t < nearest)) {
                continue;
            }
            let p = ray.at(t);
            let inside = [(a, b), (b, c), (c, a)]
                .iter()
                .all(|(from, to)| (**to - **from).cross(p - **from).dot(normal) >= 0.0);
            if inside {
                nearest = Some((t, *id));
            }
        }
        nearest
    }

    /// The segment in which a plane cuts each triangle.
    fn cuts(&self, point: DVec3, normal: DVec3) -> Vec<(DVec3, DVec3)> {
        let mut cuts = Vec::new();
        for (_, corners) in &self.triangles {
            let mut ends = Vec::new();
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let (p, q) = (corners[from], corners[to]);
                let (h, k) = ((p - point).dot(normal), (q - point).dot(normal));
                if (h >= 0.0) != (k >= 0.0) {
                    ends.push(p + (q - p) * (h / (h - k)));
                }
            }
            if let [p, q] = ends[..] {
                cuts.push((p, q));
            }
        }
        cuts
    }

    /// Shadows of the sun in light space: light along +z, shadows cast straight down.
    fn brute_force_sun(&self, ray: &Ray, to_light: DVec3, (t0, t1): (f64, f64)) -> IntervalSet {
        let mut shadows = IntervalSet::default();
        let orthogonal = |v: DVec3| (v - to_light * v.dot(to_light)).normalize();
        // Twice, as the first time cancels when ray and light are nearly parallel.
        let across = orthogonal(orthogonal(ray.direction));
        let to_plane = |v: DVec3| DVec2::new(v.dot(across), v.dot(to_light));
        let step = to_plane(ray.direction);
        for (p, q) in self.cuts(ray.origin, across.cross(to_light).normalize()) {
            let (p, q) = (to_plane(p - ray.origin), to_plane(q - ray.origin));
            let (left, right) = if p.x < q.x { (p, q) } else { (q, p) };
            let (start, end) = (left.x.max(t0 * step.x), right.x.min(t1 * step.x));
            if start >= end {
                continue;
            }
            let middle = (start + end) / 2.0;
            let height = left.y + (right.y - left.y) * (middle - left.x) / (right.x - left.x);
            if height > middle / step.x * step.y {
                shadows.insert(start / step.x, end / step.x);
            }
        }
        shadows
    }

    /// Shadows of a point light by the angle under which the light sees things.
    fn brute_force_point(&self, ray: &Ray, light: DVec3, (t0, t1): (f64, f64)) -> IntervalSet {
        let mut shadows = IntervalSet::default();
        let foot = (light - ray.origin).dot(ray.direction);
        let up = light - ray.at(foot);
        let height = up.length();
        let up = up / height;
        let angle = |v: DVec2| v.x.atan2(-v.y);
        let seen = |p: DVec3| DVec2::new((p - light).dot(ray.direction), (p - light).dot(up));
        let (from, to) = (((t0 - foot) / height).atan(), ((t1 - foot) / height).atan());
        for (p, q) in self.cuts(ray.origin, ray.direction.cross(up)) {
            let (p, q) = (seen(p), seen(q));
            let (low, high) = (angle(p).min(angle(q)), angle(p).max(angle(q)));
            // A segment that passes behind the light is seen on both sides, never in between.
            let pi = std::f64::consts::PI;
            let parts = if high - low < pi { vec![(low, high)] } else { vec![(high, pi), (-pi, low)] };
            for (low, high) in parts {
                let (start, end) = (low.max(from), high.min(to));
                if start >= end {
                    continue;
                }
                let looking = DVec2::new(((start + end) / 2.0).sin(), -((start + end) / 2.0).cos());
                let distance = p.perp_dot(q - p) / looking.perp_dot(q - p);
                if distance > 0.0 && -looking.y * distance < height {
                    shadows.insert(foot + height * start.tan(), foot + height * end.tan());
                }
            }
        }
        shadows
    }

    /// A ray that looks into the scene, and where it ends.
    fn random_ray(&self, random: &mut Random) -> (Ray, f64) {
        let (min, max) = self.tree.bounds().unwrap();
        let (centre, half) = ((min + max) / 2.0, (max - min).max_element() / 2.0);
        let origin = centre + random.direction() * half * random.between(0.5, 2.0);
        let direction = (centre + random.in_cube(half * 0.8) - origin).normalize();
        let ray = Ray { origin, direction };
        let end = self.tree.nearest_hit(&ray, 1e9, None).map_or(4.0 * half, |hit| hit.t);
        (ray, end)
    }
}

fn covered(shadows: &IntervalSet) -> f64 {
    shadows.as_slice().iter().map(|(start, end)| end - start).sum()
}

/// Root mean square difference of the lit lengths, divided by their mean.
fn relative_rmse(pairs: &[(f64, f64)]) -> f64 {
    let count = pairs.len() as f64;
    let mean = pairs.iter().map(|(_, reference)| reference).sum::<f64>() / count;
    let square = pairs.iter().map(|(value, reference)| (value - reference).powi(2)).sum::<f64>() / count;
    square.sqrt() / mean
}

fn check_hits(scene: &Scene, random: &mut Random, rays: usize) {
    let (mut found, mut disagreements) = (0, 0);
    for _ in 0..rays {
        let (ray, _) = scene.random_ray(random);
        let hit = scene.tree.nearest_hit(&ray, f64::INFINITY, None);
        let expected = scene.brute_force_hit(&ray, None);
        assert_eq!(scene.tree.any_hit(&ray, f64::INFINITY, None), hit.is_some());
        match (hit, expected) {
            (None, None) => {}
            (Some(hit), Some((t, primitive))) if hit.primitive == primitive => {
                found += 1;
                assert!((hit.t - t).abs() < 1e-9 * t, "{} {t}", hit.t);
                let [u, v] = hit.barycentrics;
                let [a, b, c] = scene.triangles.iter().find(|(id, _)| *id == primitive).unwrap().1;
                let point = a + u * (b - a) + v * (c - a);
                assert!((point - ray.at(t)).length() < 1e-9 * t);
                // And what lies behind the first hit.
                let next = Ray { origin: ray.at(hit.t), ..ray };
                let behind = scene.tree.nearest_hit(&next, f64::INFINITY, Some(primitive));
                let expected_behind = scene.brute_force_hit(&next, Some(primitive));
                if behind.map(|hit| hit.primitive) != expected_behind.map(|(_, id)| id) {
                    disagreements += 1;
                }
            }
            _ => disagreements += 1,
        }
    }
    assert!(found > rays / 50, "{found}");
    assert!(disagreements * 1000 <= rays, "{disagreements} of {rays}");
}

#[test]
fn hits_equal_brute_force_on_soups() {
    let mut random = Random(1);
    for (count, size) in [(1, 2.0), (8, 1.0), (9, 1.0), (40, 0.5), (2000, 0.2)] {
        check_hits(&Scene::one(soup(&mut random, count, 3.0, size)), &mut random, 1000);
    }
}

#[test]
fn hits_equal_brute_force_on_instances() {
    let mut random = Random(2);
    let scene = Scene::instanced(&mut random, DVec3::ZERO);
    check_hits(&scene, &mut random, 2000);
}

#[test]
fn hits_equal_brute_force_far_from_the_origin() {
    let mut random = Random(3);
    let scene = Scene::instanced(&mut random, DVec3::new(1e6, -2e6, 3e6));
    let centre = scene.tree.bounds().unwrap();
    let (mut hits, mut differences) = (0, 0);
    for _ in 0..500 {
        let origin = random.in_cube(1.0);
        let target = DVec3::new(
            random.between(centre.0.x, centre.1.x),
            random.between(centre.0.y, centre.1.y),
            random.between(centre.0.z, centre.1.z),
        );
        let ray = Ray { origin, direction: (target - origin).normalize() };
        let hit = scene.tree.nearest_hit(&ray, f64::INFINITY, None).map(|hit| hit.primitive);
        let expected = scene.brute_force_hit(&ray, None).map(|(_, id)| id);
        hits += usize::from(hit.is_some());
        differences += usize::from(hit != expected);
    }
    assert!(hits > 100 && differences <= 1, "{hits} {differences}");
}

fn sun_error(scene: &Scene, random: &mut Random, rays: usize, angle: Option<f64>) -> f64 {
    let pairs: Vec<(f64, f64)> = (0..rays)
        .map(|i| {
            let (ray, end) = scene.random_ray(random);
            let to_light = match angle {
                None => random.direction(),
                Some(angle) => {
                    let side = ray.direction.cross(random.direction()).normalize();
                    let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
                    (sign * ray.direction + angle * side).normalize()
                }
            };
            let range = (end * 0.1, end);
            let plane = LightPlane::towards_direction(&ray, to_light, range).unwrap();
            let mut shadows = IntervalSet::default();
            scene.tree.add_shadows(&plane, &mut shadows);
            let expected = scene.brute_force_sun(&ray, to_light, range);
            let length = range.1 - range.0;
            (length - covered(&shadows), length - covered(&expected))
        })
        .collect();
    relative_rmse(&pairs)
}

fn point_error(scene: &Scene, random: &mut Random, rays: usize, angle: Option<f64>) -> f64 {
    let (min, max) = scene.tree.bounds().unwrap();
    let pairs: Vec<(f64, f64)> = (0..rays)
        .map(|i| {
            let (ray, end) = scene.random_ray(random);
            let half = (max - min).max_element() / 2.0;
            let light = match angle {
                None => (min + max) / 2.0 + random.in_cube(2.0 * half),
                Some(angle) => {
                    let side = ray.direction.cross(random.direction()).normalize();
                    let distance = if i % 2 == 0 { end * 2.0 } else { -end };
                    ray.at(distance) + angle * distance * side
                }
            };
            let range = (end * 0.1, end);
            let plane = LightPlane::towards_point(&ray, light, range).unwrap();
            let mut shadows = IntervalSet::default();
            scene.tree.add_shadows(&plane, &mut shadows);
            let expected = scene.brute_force_point(&ray, light, range);
            let length = range.1 - range.0;
            (length - covered(&shadows), length - covered(&expected))
        })
        .collect();
    relative_rmse(&pairs)
}

#[test]
fn sun_shadows_equal_brute_force() {
    let mut random = Random(4);
    for scene in [
        Scene::one(soup(&mut random, 8, 3.0, 1.0)),
        Scene::one(soup(&mut random, 500, 3.0, 0.2)),
        Scene::instanced(&mut random, DVec3::ZERO),
    ] {
        let error = sun_error(&scene, &mut random, 1000, None);
        assert!(error < 1e-6, "{error:e}");
    }
}

#[test]
fn point_shadows_equal_brute_force() {
    let mut random = Random(5);
    for scene in [
        Scene::one(soup(&mut random, 8, 3.0, 1.0)),
        Scene::one(soup(&mut random, 500, 3.0, 0.2)),
        Scene::instanced(&mut random, DVec3::ZERO),
    ] {
        let error = point_error(&scene, &mut random, 1000, None);
        assert!(error < 2e-6, "{error:e}");
    }
}

/// The sun in the picture, or behind the viewer.
#[test]
fn shadows_hold_up_as_ray_and_light_become_parallel() {
    let mut random = Random(6);
    let scene = Scene::instanced(&mut random, DVec3::ZERO);
    for exponent in 1..=10 {
        let angle = 10_f64.powi(-exponent);
        // Directions in double precision know the angle to 1e-16 / angle.
        let tolerance = 1e-6 + 2e-15 / angle;
        let sun = sun_error(&scene, &mut random, 300, Some(angle));
        let point = point_error(&scene, &mut random, 300, Some(angle));
        assert!(sun < tolerance, "sun {angle:e}: {sun:e}");
        assert!(point < tolerance, "point {angle:e}: {point:e}");
    }
}

#[test]
fn shadows_do_not_care_where_the_scene_is() {
    let mut random = Random(7);
    let scene = Scene::instanced(&mut random, DVec3::new(2e6, 1e6, -1e6));
    // Double precision itself knows such places to 5e-10.
    let error = sun_error(&scene, &mut random, 300, None);
    assert!(error < 1e-6, "{error:e}");
}

#[test]
fn collinear_rays_and_lights_have_no_plane() {
    let ray = Ray { origin: DVec3::ZERO, direction: DVec3::new(0.6, 0.0, 0.8) };
    for sign in [1.0, -1.0] {
        assert!(LightPlane::towards_direction(&ray, sign * ray.direction, (0.0, 1.0)).is_none());
        assert!(LightPlane::towards_point(&ray, ray.at(sign * 5.0), (0.0, 1.0)).is_none());
    }
    assert!(LightPlane::towards_point(&ray, ray.origin, (0.0, 1.0)).is_none());
}

/// A flat fan in the plane of ray and light, with vertices on the ray: every degenerate case at once.
#[test]
fn what_lies_in_the_plane_of_ray_and_light_throws_no_shadow() {
    let positions: Vec<Vec3> =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 2.0, 0.0]].map(Vec3::from_array).into();
    let scene = Scene::one((positions, vec![[0, 1, 2], [1, 3, 2], [0, 0, 1]]));
    let ray = Ray { origin: DVec3::new(-1.0, 0.0, 0.0), direction: DVec3::X };
    let mut shadows = IntervalSet::default();
    let sun = LightPlane::towards_direction(&ray, DVec3::Y, (0.0, 5.0)).unwrap();
    scene.tree.add_shadows(&sun, &mut shadows);
    let lamp = LightPlane::towards_point(&ray, DVec3::new(1.0, 3.0, 0.0), (0.0, 5.0)).unwrap();
    scene.tree.add_shadows(&lamp, &mut shadows);
    assert!(shadows.as_slice().is_empty());
    // Seen edge-on it is hit nowhere, or at a distance that is a number.
    let hit = scene.tree.nearest_hit(&ray, f64::INFINITY, None);
    assert!(hit.is_none_or(|hit| hit.t.is_finite()));
}

#[test]
fn clipped_ends_are_the_asked_ends() {
    let positions: Vec<Vec3> =
        [[-50.0, 2.0, -50.0], [50.0, 2.0, -50.0], [0.0, 2.0, 80.0]].map(Vec3::from_array).into();
    let scene = Scene::one((positions, vec![[0, 1, 2]]));
    let ray = Ray { origin: DVec3::new(0.1, 0.0, 0.3), direction: DVec3::new(0.6, 0.0, 0.8) };
    let range = (0.1, 0.7);
    for plane in [
        LightPlane::towards_direction(&ray, DVec3::new(0.1, 0.8, 0.2).normalize(), range),
        LightPlane::towards_point(&ray, DVec3::new(0.1, 8.0, 0.2), range),
    ] {
        let mut shadows = IntervalSet::default();
        scene.tree.add_shadows(&plane.unwrap(), &mut shadows);
        assert_eq!(shadows.as_slice(), &[range]);
    }
}

/// Single precision knows neither which of the two is met, nor by metres where they meet.
#[test]
fn triangles_of_a_plane_are_met_in_it_however_large_they_are() {
    let corner = |x: f32, z: f32| Vec3::new(5e6 * x, 0.0, 5e6 * z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let scene = Scene::one((corners, vec![[0, 2, 1], [0, 3, 2]]));
    let mut random = Random(12);
    for _ in 0..3000 {
        let target = DVec3::new(random.between(-30.0, 30.0), 0.0, random.between(-30.0, 30.0));
        let origin = DVec3::new(0.3, random.between(0.5, 3.0), -0.2);
        let ray = Ray { origin, direction: (target - origin).normalize() };
        let hit = scene.tree.nearest_hit(&ray, f64::INFINITY, None).unwrap();
        let point = ray.at(hit.t);
        assert!((point - target).length() < 1e-8, "{point} for {target}");
        // So nothing of the plane is in the light's way.
        let up = Ray { origin: point, direction: DVec3::new(0.4, 0.8, 0.3).normalize() };
        assert!(!scene.tree.any_hit(&up, f64::INFINITY, Some(hit.primitive)), "{point}");
    }
}

#[test]
fn degenerate_input_is_left_out() {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN, Vec3::splat(f32::INFINITY)];
    let triangles = [[0, 1, 9], [0, 1, 3], [0, 1, 4], [0, 1, 2], [1, 1, 1]];
    let mesh = Arc::new(MeshTree::new(&positions, &triangles));
    let ray = Ray { origin: DVec3::new(0.2, 0.2, -1.0), direction: DVec3::Z };
    let flat = DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0));
    let placed = [flat, DAffine3::IDENTITY, DAffine3::from_scale(DVec3::ZERO)]
        .map(|relative_from_mesh| PlacedMesh { mesh: mesh.clone(), relative_from_mesh });
    let hit = InstanceTree::new(placed.into()).nearest_hit(&ray, 10.0, None).unwrap();
    assert_eq!(hit.primitive, PrimitiveId { instance: 1, triangle: 3 });

    let nothing = InstanceTree::new(vec![]);
    assert!(nothing.bounds().is_none() && nothing.nearest_hit(&ray, 10.0, None).is_none());
    let empty =
        PlacedMesh { mesh: Arc::new(MeshTree::new(&[], &[])), relative_from_mesh: DAffine3::IDENTITY };
    assert!(!InstanceTree::new(vec![empty]).any_hit(&ray, 10.0, None));
}

/// Builders like to stumble here: all boxes the same, all in a row, growing to 1e21.
#[test]
fn degenerate_trees_are_built_and_searched() {
    let triangle = |scale: f32, at: f32| {
        [Vec3::new(at, 0.0, 0.0), Vec3::new(at + scale, 0.0, 0.0), Vec3::new(at, scale, 0.0)]
    };
    let same = |_: u32| triangle(1.0, 0.0);
    let row = |i: u32| triangle(0.5, i as f32);
    let growing = |i: u32| triangle(1.01_f32.powi(i as i32), 0.0);
    let shapes: [&dyn Fn(u32) -> [Vec3; 3]; 3] = [&same, &row, &growing];
    for (number, shape) in shapes.into_iter().enumerate() {
        let positions: Vec<Vec3> = (0..5000).flat_map(shape).collect();
        let triangles: Vec<[u32; 3]> = (0..5000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let scene = Scene::one((positions, triangles));
        let ray = Ray { origin: DVec3::new(0.1, 0.1, -1.0), direction: DVec3::Z };
        let hit = scene.tree.nearest_hit(&ray, 10.0, None);
        assert!(hit.is_some_and(|hit| (hit.t - 1.0).abs() < 1e-9), "shape {number}: {hit:?}");
    }
    // Areas of such boxes overflow; the tree is built all the same.
    let positions: Vec<Vec3> = (0..3000).map(|i| Vec3::splat(1e30) * i as f32).collect();
    MeshTree::new(&positions, &(0..1000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect::<Vec<_>>());
}

/// A closed sphere: an octahedron divided `levels` times. Mesh and placement are meant to be uneven.
fn sphere(levels: u32) -> Mesh {
    let mut positions: Vec<Vec3> = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z].into();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for (x, y, z) in [(0, 1, 2), (0, 1, 5), (0, 4, 2), (0, 4, 5), (3, 1, 2), (3, 1, 5), (3, 4, 2), (3, 4, 5)]
    {
        triangles.push([x, y, z]);
    }
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |p: u32, q: u32| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    positions.push((positions[p as usize] + positions[q as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (positions, triangles)
}

/// A sphere squeezed into a needle, so that its triangles are needles too.
fn needle() -> Mesh {
    let (positions, triangles) = sphere(4);
    (positions.iter().map(|p| *p * Vec3::new(1.0, 1e-3, 1e-5)).collect(), triangles)
}

#[test]
fn no_ray_passes_between_the_triangles_of_a_closed_mesh() {
    let mut random = Random(8);
    for mesh in [sphere(0), sphere(2), sphere(5), needle()] {
        let placement = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.7, -1.3, 0.4),
            random.rotation(),
            DVec3::new(3.0, -7.0, 20.0),
        );
        let scene = Scene::new(&[mesh], &[(0, placement)]);
        for _ in 0..250_000 {
            let (_, corners) = scene.triangles[random.below(scene.triangles.len())];
            let along = random.unit();
            let target = match random.below(4) {
                0 => corners[0],
                _ => corners[1] + (corners[2] - corners[1]) * along,
            };
            // From inside, so that it must hit, whatever the angle.
            let inside = placement.transform_point3(DVec3::ZERO);
            let beyond = target + (target - inside) * random.between(0.1, 30.0);
            let (from, to) = if random.below(2) == 0 { (inside, beyond) } else { (beyond, inside) };
            let ray = Ray { origin: from, direction: (to - from).normalize() };
            assert!(scene.tree.any_hit(&ray, (to - from).length(), None), "{ray:?}");
        }
    }
}

/// The shadow of a closed convex mesh is one interval, wherever the plane cuts it.
#[test]
fn no_light_leaks_between_the_triangles_of_a_closed_mesh() {
    let mut random = Random(9);
    for mesh in [sphere(2), sphere(4), needle()] {
        let placement = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.7, -1.3, 0.4),
            random.rotation(),
            DVec3::new(3.0, -7.0, 20.0),
        );
        let scene = Scene::new(&[mesh], &[(0, placement)]);
        let centre = placement.translation;
        let mut shadowed = 0;
        for _ in 0..5000 {
            // The plane goes through the ray's origin, a vertex or a point of an edge, and the light.
            let (_, corners) = scene.triangles[random.below(scene.triangles.len())];
            let target = if random.below(2) == 0 { corners[0] } else { (corners[1] + corners[2]) / 2.0 };
            let to_light = random.direction();
            let below = target - to_light * random.between(2.0, 10.0);
            let direction = random.direction();
            let ray = Ray { origin: below - 20.0 * direction, direction };
            if (ray.origin - centre).length() < 3.0 || scene.tree.any_hit(&ray, 100.0, None) {
                continue;
            }
            for plane in [
                LightPlane::towards_direction(&ray, to_light, (0.0, 100.0)).unwrap(),
                LightPlane::towards_point(&ray, target + 5.0 * to_light, (0.0, 100.0)).unwrap(),
            ] {
                let mut shadows = IntervalSet::default();
                scene.tree.add_shadows(&plane, &mut shadows);
                assert!(shadows.as_slice().len() <= 1, "{shadows:?}");
                shadowed += shadows.as_slice().len();
            }
        }
        assert!(shadowed > 1000, "{shadowed}");
    }
}
