//! The slow truth about a camera ray: every triangle of the scene, no tree, double precision. In go a
//! snapshot's scene and a ray. Out come what the ray may meet, which parts of it are lit, and its light.
//!
//! Shadows are found another way than the renderer finds them. A triangle's shadow volume has four planes,
//! each of which bounds the ray by one linear inequality. Nothing is projected onto a plane, so nothing
//! degenerates as ray and light become parallel.

use crate::numerics::fog_truth::{FogTruth, integral};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;
use sunfleck::color::Rgb;
use sunfleck::light::LightPlace;
use sunfleck::math::{IntervalSet, Ray};
use sunfleck::scene::Scene;
use sunfleck::snapshot::{FrozenLight, Luminaire, Snapshot};

/// How far single precision may move an edge, as a fraction of its mesh's largest coordinate: the boxes'
/// padding (`accel`), 16 roundings.
const BLUR: f64 = 16.0 * 6e-8;

/// Rays so near to the light's direction, in radians, are within one line with it.
const IN_LINE: f64 = 1e-9;

/// A scene without any structure.
pub(crate) struct Truth {
    triangles: Vec<Face>,
    fog: FogTruth,
    lights: Vec<FrozenLight>,
    background: Rgb,
}

/// A triangle in relative space.
struct Face {
    corners: [DVec3; 3],
    albedo: Rgb,
    emission: Rgb,
    /// How uncertain single precision is about its edges, metres.
    blur: f64,
}

/// A surface that a ray may be said to meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    face: usize,
    /// Between which distances, metres.
    pub(crate) t: (f64, f64),
    /// Not so near to the triangle's edge that rounding decides.
    pub(crate) is_certain: bool,
}

/// The light of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    /// `None` where rounding decides what lies in shadow.
    pub(crate) shafts: Option<Rgb>,
    pub(crate) transmittance: Rgb,
    /// `None` where rounding decides whether the surface is lit.
    pub(crate) surface: Option<Rgb>,
}

impl Truth {
    pub(crate) fn new(scene: &Scene, snapshot: &Snapshot) -> Self {
        Self::lit_by(scene, snapshot, snapshot.lights.iter().map(Luminaire::centre).collect())
    }

    /// The scene in another light.
    pub(crate) fn lit_by(scene: &Scene, snapshot: &Snapshot, lights: Vec<FrozenLight>) -> Self {
        let placements = scene.placements(0.0);
        let relative_from = |node: usize| {
            let mut relative = placements[node].world_from_node;
            relative.translation -= snapshot.view.eye;
            relative
        };
        let mut triangles = Vec::new();
        for instance in &scene.instances {
            let relative_from_mesh: DAffine3 = relative_from(instance.node);
            let mesh = &scene.meshes[instance.mesh];
            let largest = mesh.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
            let scale = relative_from_mesh.matrix3.to_cols_array().map(f64::abs).iter().sum::<f64>() / 3.0;
            for triangle in &mesh.triangles {
                let corner = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
                let material = &scene.materials[instance.material.unwrap_or(triangle.material)];
                triangles.push(Face {
                    corners: triangle.vertices.map(|v| relative_from_mesh.transform_point3(corner(v))),
                    albedo: material.base_color,
                    emission: material.emission,
                    blur: BLUR * scale * f64::from(largest),
                });
            }
        }
        let fog = FogTruth::new(scene.fogs.iter().map(|fog| (fog, relative_from(fog.node))));
        Self { triangles, fog, lights, background: snapshot.background }
    }

    /// What a ray may meet first: nothing (infinite) or the first certain surface, and the uncertain
    /// ones before it.
    pub(crate) fn candidates(&self, ray: &Ray) -> Vec<Candidate> {
        let meets = |(face, triangle): (usize, &Face)| {
            let (t, is_certain) = triangle.meets(ray)?;
            Some(Candidate { face, t, is_certain })
        };
        let mut candidates: Vec<Candidate> =
            self.triangles.iter().enumerate().filter_map(meets).filter(|met| met.t.1 > 1e-12).collect();
        candidates.sort_by(|a, b| a.t.0.total_cmp(&b.t.0));
        let certain = candidates.iter().filter(|met| met.is_certain);
        let first = certain.map(|met| met.t.1).fold(f64::INFINITY, f64::min);
        candidates.retain(|met| met.t.0 <= first);
        candidates
    }

    /// Everything that reaches the camera along a ray that ends at `met`, at distance `t`.
    pub(crate) fn light(&self, ray: &Ray, met: Option<&Candidate>, t: f64) -> Light {
        let mut shafts = Some(Rgb::ZERO);
        let mut surface = Some(met.map_or(self.background, |met| self.triangles[met.face].emission));
        for light in &self.lights {
            let is_decided = !self.grazes_in_line(ray, light.place());
            shafts = shafts
                .filter(|_| is_decided)
                .map(|sum| sum + integral(&self.fog, ray, light, &self.shadows(ray, light.place(), t), t));
            let reflected = met.map_or(Some(Rgb::ZERO), |met| self.reflected(ray, met, t, light));
            surface = surface.zip(reflected).map(|(sum, reflected)| sum + reflected);
        }
        Light { shafts, transmittance: self.fog.transmittance(ray.origin, ray.direction, t), surface }
    }

    /// The parts of `(0, end)` that the light does not reach.
    pub(crate) fn shadows(&self, ray: &Ray, light: LightPlace, end: f64) -> IntervalSet {
        let mut shadows = IntervalSet::default();
        for triangle in &self.triangles {
            if let Some((start, end)) = triangle.shadow(ray, light, (0.0, end.min(1e30))) {
                shadows.insert(start, end);
            }
        }
        shadows
    }

    /// Whether an edge or a vertex lies on the one line of ray and light: then rounding
    /// decides about the shadows.
    fn grazes_in_line(&self, ray: &Ray, light: LightPlace) -> bool {
        let axis = match light {
            LightPlace::Towards(to_light) => to_light,
            LightPlace::At(position) => (position - ray.origin).normalize_or_zero(),
        };
        let grazes = |triangle: &Face| matches!(triangle.meets(ray), Some((_, false)));
        axis.cross(ray.direction).length() < IN_LINE && self.triangles.iter().any(grazes)
    }

    /// Lambert's law; `None` where rounding decides about visibility.
    fn reflected(&self, ray: &Ray, met: &Candidate, t: f64, light: &FrozenLight) -> Option<Rgb> {
        let face = &self.triangles[met.face];
        let point = ray.at(t);
        let (to_light, distance, arriving) = light.arriving_at(point);
        let [a, b, c] = face.corners;
        let normal = (b - a).cross(c - a).normalize();
        let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        let cos = normal.dot(to_light);
        if !met.is_certain {
            return None;
        }
        if cos <= 0.0 || arriving == Rgb::ZERO {
            return Some(Rgb::ZERO);
        }
        let shadow_ray = Ray { origin: point, direction: to_light };
        for (index, other) in self.triangles.iter().enumerate() {
            let Some(((near, far), is_certain)) = other.meets(&shadow_ray) else { continue };
            let blur = 4.0 * (face.blur + other.blur) / other.sine(to_light).max(1e-12);
            if index == met.face || far < -blur || near > distance + blur {
                continue;
            }
            if far < blur || near > distance - blur {
                // In the same plane, or the light in it: nobody's shadow, nearly.
                let is_near = other.distance_to_plane(point) <= face.blur + other.blur;
                if other.sine(to_light) <= 1e-6 || is_near && other.is_parallel_to(face) {
                    continue;
                }
                return None;
            }
            return is_certain.then_some(Rgb::ZERO);
        }
        let through = self.fog.transmittance(point, to_light, distance);
        Some(FRAC_1_PI * cos * face.albedo * arriving * through)
    }
}

impl Face {
    /// Between which distances the ray's line meets the triangle, and whether that is certain.
    fn meets(&self, ray: &Ray) -> Option<((f64, f64), bool)> {
        // Seen along the ray: a triangle in two dimensions, which holds the origin or not.
        let right = ray.direction.any_orthonormal_vector();
        let down = ray.direction.cross(right);
        let from_origin = self.corners.map(|corner| corner - ray.origin);
        let seen = from_origin.map(|corner| DVec2::new(corner.dot(right), corner.dot(down)));
        let depths = from_origin.map(|corner| corner.dot(ray.direction));
        let edges = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (seen[i], seen[j]));
        let nearest = edges.iter().map(|(p, q)| distance_to_segment(*p, *q)).fold(f64::INFINITY, f64::min);
        let turns = edges.map(|(p, q)| p.perp_dot(q));
        let area: f64 = turns.iter().sum();
        let is_inside = turns.iter().all(|turn| turn * area.signum() >= 0.0) && area != 0.0;
        // Directions, too, are rounded to doubles: that moves what is far away.
        let far = depths.map(f64::abs).into_iter().fold(0.0, f64::max);
        let is_certain = nearest > self.blur + 1e-14 * far;
        if is_inside && is_certain {
            let weights = [turns[1] / area, turns[2] / area, turns[0] / area];
            let t = (0..3).map(|corner| weights[corner] * depths[corner]).sum();
            return Some(((t, t), true));
        }
        let all = (depths.into_iter().fold(f64::INFINITY, f64::min), depths.into_iter().fold(0.0, f64::max));
        (!is_certain).then_some((all, false))
    }

    /// Which part of the ray lies in the triangle's shadow volume.
    fn shadow(&self, ray: &Ray, light: LightPlace, (start, end): (f64, f64)) -> Option<(f64, f64)> {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        // Each plane of the volume as `value + t * growth`, not negative inside; all of them turn their
        // sides as the triangle turns its side to the light.
        let to_light = match light {
            LightPlace::Towards(to_light) => to_light,
            LightPlace::At(position) => position - a,
        };
        let facing = normal.dot(to_light);
        if facing == 0.0 {
            return None;
        }
        let side = facing.signum();
        let mut inside = (start, end);
        let mut clip = |value: f64, growth: f64| {
            let root = -value / growth;
            if growth > 0.0 {
                inside.0 = inside.0.max(root);
            } else if growth < 0.0 {
                inside.1 = inside.1.min(root);
            } else if value < 0.0 {
                inside.1 = f64::NEG_INFINITY;
            }
        };
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let (value, growth) = match light {
                LightPlace::Towards(to_light) => {
                    let plane = (q - p).cross(to_light);
                    (plane.dot(p - ray.origin), (p - q).dot(exact_cross(to_light, ray.direction)))
                }
                LightPlace::At(light) => {
                    let plane = exact_cross(p - light, q - light);
                    (plane.dot(light - ray.origin), -plane.dot(ray.direction))
                }
            };
            clip(side * value, side * growth);
        }
        clip(side * normal.dot(a - ray.origin), -side * normal.dot(ray.direction));
        (inside.0 < inside.1).then_some(inside)
    }

    /// The sine of the angle between a direction and the triangle's plane.
    fn sine(&self, direction: DVec3) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).try_normalize().map_or(0.0, |normal| normal.dot(direction).abs())
    }

    fn is_parallel_to(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|face| {
            let [a, b, c] = face.corners;
            (b - a).cross(c - a).normalize_or_zero()
        });
        a.cross(b).length() < 1e-3
    }

    fn distance_to_plane(&self, point: DVec3) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).try_normalize().map_or(0.0, |normal| normal.dot(point - a).abs())
    }
}

fn distance_to_segment(p: DVec2, q: DVec2) -> f64 {
    let along = q - p;
    let fraction = (-p.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    if fraction.is_nan() { p.length() } else { (p + fraction * along).length() }
}

/// The cross product to within two roundings even where it cancels (Kahan's difference of products).
fn exact_cross(a: DVec3, b: DVec3) -> DVec3 {
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let product = c * d;
        let error = (-c).mul_add(d, product);
        a.mul_add(b, -product) + error
    };
    DVec3::new(difference(a.y, b.z, a.z, b.y), difference(a.z, b.x, a.x, b.z), difference(a.x, b.y, a.y, b.x))
}
