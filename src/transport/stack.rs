//! Many blended surfaces on one ray. In go the ray, its surfaces and the lights. Out comes the radiance that
//! each surface scatters towards the ray's origin. Invariant: `n` surfaces take `n log n` steps. Separate
//! shadow rays, each through as many surfaces, would take `n^2 log n`.
//!
//! All surfaces that attenuate a light anywhere on the ray lie in the plane through both. So one traversal of
//! the tree finds them for all surfaces at once, and a sweep along the ray keeps the product of
//! transmittances. Under a lamp or sun the values are those of shadow rays, to rounding. Textured surfaces
//! are evaluated one by one until the transmittance is negligible. Light of the sky, and mirrors, are
//! evaluated at a few surfaces that represent all.

use super::direct;
use super::lit_segments::{met_at, shadows_in_line};
use super::path::Illumination;
use crate::accel::{LightPlane, PrimitiveId, TriangleShadow};
use crate::color::Rgb;
use crate::math::{Ray, RunningProduct, Sampler};
use crate::snapshot::{BlendedHit, FrozenLight, NEGLIGIBLE, Snapshot};

/// Number of surfaces up to which each has shadow rays of its own, which cost less than the traversal.
const MANY: usize = 16;

/// Number of surfaces that represent all where each would need a ray of its own.
const CHOSEN: usize = 8;

/// Direct light on the surfaces of a ray, if they are many.
pub(super) struct Stack {
    /// Radiance that each scatters of lights, W m^-2 sr^-1.
    pub(super) scattered: Vec<Rgb>,
    /// Weight of the sky's and of mirrored light at each of them; 0 if another surface represents it.
    pub(super) shares: Vec<f64>,
}

impl Stack {
    /// `None` if the surfaces are few.
    pub(super) fn of(
        snapshot: &Snapshot,
        light: &Illumination,
        ray: &Ray,
        blended: &[BlendedHit],
        sampler: &mut Sampler,
    ) -> Option<Self> {
        if blended.len() <= MANY {
            return None;
        }
        let mut scattered = vec![Rgb::ZERO; blended.len()];
        for light in light.lights {
            let through = let_through(snapshot, ray, light, blended);
            for ((sum, hit), through) in scattered.iter_mut().zip(blended).zip(through) {
                *sum += direct::scattered_past_blended(snapshot, light, &hit.point, through);
            }
        }
        Some(Self { scattered, shares: shares(blended, sampler.next_1d()) })
    }
}

/// Transmittance of blended surfaces from a light to each of the ray's surfaces.
fn let_through(snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, blended: &[BlendedHit]) -> Vec<Rgb> {
    // Twice as far, so that the last surface lies inside the range of its occluders.
    let range = (0.0, 2.0 * blended.last().map_or(0.0, |hit| hit.t));
    let plane = match *light {
        FrozenLight::Sun { to_light, .. } => LightPlane::towards_direction(ray, to_light, range),
        FrozenLight::Point { position, .. } => LightPlane::towards_point(ray, position, range),
    };
    let mut shadows = Vec::new();
    match &plane {
        Some(plane) => snapshot.casting_blended().add_each_shadow(plane, &mut shadows),
        None => shadows.extend(shadows_in_line(snapshot, ray, light, 0.0).map(|(shadow, _)| shadow)),
    }
    let transmittance = |shadow: &TriangleShadow, t: f64| {
        if plane.is_some() {
            return met_at(snapshot, ray, light, shadow.primitive, t);
        }
        // Ray and light meet it at the same point, at one end of the shadow.
        let facet = snapshot.facet(shadow.primitive);
        let met = if shadow.start.is_finite() { shadow.start } else { shadow.end };
        facet.seen_along(ray, met).see_through
    };
    Sweep::new(snapshot, shadows, &transmittance).along(blended)
}

/// Sweep along the ray, through the shadows on it.
struct Sweep<'a> {
    /// Shadows, by where they start.
    shadows: Vec<TriangleShadow>,
    /// Their indices, by where they end.
    ends: Vec<usize>,
    /// Their indices, by triangle.
    of_triangles: Vec<(PrimitiveId, usize)>,
    /// Transmittances of untextured triangles.
    transmittances: Vec<Option<Rgb>>,
    product: RunningProduct,
    /// Shadows whose transmittance differs from place to place.
    textured: Vec<usize>,
    transmittance: &'a dyn Fn(&TriangleShadow, f64) -> Rgb,
}

impl<'a> Sweep<'a> {
    fn new(
        snapshot: &Snapshot,
        mut shadows: Vec<TriangleShadow>,
        transmittance: &'a dyn Fn(&TriangleShadow, f64) -> Rgb,
    ) -> Self {
        // A fixed order of factors: rounding must not depend on the tree's order.
        shadows.sort_unstable_by(|a, b| {
            let by_place = a.start.total_cmp(&b.start).then(a.end.total_cmp(&b.end));
            by_place.then(a.primitive.cmp(&b.primitive))
        });
        let mut ends: Vec<usize> = (0..shadows.len()).collect();
        ends.sort_by(|a, b| shadows[*a].end.total_cmp(&shadows[*b].end));
        let mut of_triangles: Vec<_> = shadows.iter().map(|shadow| shadow.primitive).zip(0..).collect();
        of_triangles.sort_unstable();
        let alike = |shadow: &TriangleShadow| {
            let is_alike = !snapshot.is_textured(shadow.primitive);
            is_alike.then(|| transmittance(shadow, 0.5 * (shadow.start + shadow.end)))
        };
        let transmittances = shadows.iter().map(alike).collect();
        let mut product = RunningProduct::default();
        product.start(shadows.len());
        Self { shadows, ends, of_triangles, transmittances, product, textured: Vec::new(), transmittance }
    }

    /// Transmittances to surfaces given in order along the ray.
    fn along(mut self, blended: &[BlendedHit]) -> Vec<Rgb> {
        let (mut begun, mut ended) = (0, 0);
        let mut through = Vec::with_capacity(blended.len());
        for hit in blended {
            while self.shadows.get(begun).is_some_and(|shadow| shadow.start < hit.t) {
                self.begin(begun);
                begun += 1;
            }
            while let Some(&index) = self.ends.get(ended).filter(|index| self.shadows[**index].end <= hit.t) {
                self.end(index);
                ended += 1;
            }
            through.push(self.through_to(hit));
        }
        through
    }

    fn begin(&mut self, index: usize) {
        match self.transmittances[index] {
            Some(transmittance) => self.product.set(index, transmittance),
            None => self.textured.push(index),
        }
    }

    fn end(&mut self, index: usize) {
        match self.transmittances[index] {
            Some(_) => self.product.set(index, Rgb::ONE),
            None => self.textured.retain(|other| *other != index),
        }
    }

    /// Transmittance to a surface, without its own.
    fn through_to(&mut self, hit: &BlendedHit) -> Rgb {
        let primitive = hit.point.primitive;
        let own = self.of_triangles.partition_point(|(other, _)| *other < primitive);
        let own = self.of_triangles.get(own).filter(|(other, _)| *other == primitive).map(|(_, own)| *own);
        let own_factor = own.and_then(|own| {
            let shadow = &self.shadows[own];
            let is_active = shadow.start < hit.t && hit.t < shadow.end;
            self.transmittances[own].filter(|_| is_active).map(|factor| (own, factor))
        });
        if let Some((own, _)) = own_factor {
            self.product.set(own, Rgb::ONE);
        }
        let mut through = self.product.get();
        if let Some((own, factor)) = own_factor {
            self.product.set(own, factor);
        }
        for index in self.textured.iter().filter(|index| Some(**index) != own) {
            if through.max_element() <= NEGLIGIBLE {
                break;
            }
            through *= (self.transmittance)(&self.shadows[*index], hit.t);
        }
        through
    }
}

/// Weights of surfaces chosen in proportion to their visibility from the ray's origin, and 0 for the others.
/// The expected value of each is 1 (systematic sampling: Madow 1949, "On the theory of systematic sampling,
/// II").
fn shares(blended: &[BlendedHit], u: f64) -> Vec<f64> {
    let mut seen_through = Rgb::ONE;
    let weights: Vec<f64> = blended
        .iter()
        .map(|hit| {
            let weight = hit.point.alpha * seen_through.max_element();
            seen_through *= hit.point.see_through;
            weight
        })
        .collect();
    let step = weights.iter().sum::<f64>() / CHOSEN as f64;
    let mut passed = 0.0;
    let samples_before = |passed: f64| (passed / step + u).floor();
    let share = |weight: f64| {
        let before = samples_before(passed);
        passed += weight;
        let samples = samples_before(passed) - before;
        if samples > 0.0 { samples * step / weight } else { 0.0 }
    };
    weights.into_iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fog::LitSegments;
    use crate::math::MULTIPLICATIONS;
    use crate::scene::{
        AlphaMode, Camera, Clip, Instance, Lens, Material, Mesh, Motion, Node, Scene, Texture, Track,
        Triangle, Wrap,
    };
    use crate::snapshot::{Emission, LampShape, MeshTrees, Shutter};
    use crate::transport::Branches;
    use crate::transport::lit_segments::shade;
    use crate::transport::visibility::Way;
    use glam::{DAffine3, DVec2, DVec3, Vec2};
    use proptest::prelude::*;

    /// One blended triangle across the ray that goes along -Z from the origin.
    type Layer = ([f64; 3], [f64; 2], f64);

    fn layer() -> impl Strategy<Value = Layer> {
        let tilt = prop::array::uniform2(-0.5..0.5_f64);
        (prop::array::uniform3(-1.0..1.0_f64), tilt, 0.02..0.6_f64)
    }

    fn scene(layers: &[Layer], is_textured: bool) -> Scene {
        let node = || Node {
            name: String::new(),
            parent: None,
            motion: Motion::Still(DAffine3::IDENTITY),
            visible: Track::from(true),
        };
        let camera = Camera {
            name: String::new(),
            node: 0,
            lens: Lens::Perspective { fov_y: Track::from(1.0) },
            shift: DVec2::ZERO,
            aperture: None,
            clip: Clip::NONE,
        };
        let texels = [0.15, 0.0, 0.98, 0.5].map(|alpha| [1.0, 1.0, 1.0, alpha]).to_vec();
        let texture = Texture {
            name: String::new(),
            width: 2,
            height: 2,
            texels: texels.into(),
            wrap: [Wrap::Repeat; 2],
        };
        let material = |(.., opacity): &Layer| Material {
            alpha_mode: AlphaMode::Blend,
            opacity: *opacity,
            base_color_texture: is_textured.then_some(0),
            ..Material::default()
        };
        let mesh = |&([x, y, z], [tilt_x, tilt_y], _): &Layer| {
            let centre = DVec3::new(x, y, -5.0 + 3.0 * z);
            let corner = |a: f64, b: f64| (centre + DVec3::new(a, b, tilt_x * a + tilt_y * b)).as_vec3();
            Mesh {
                positions: vec![corner(-6.0, -5.0), corner(6.0, -4.0), corner(0.5, 7.0)],
                uvs: vec![Vec2::ZERO, Vec2::new(9.0, 1.0), Vec2::new(2.0, 7.0)],
                triangles: vec![Triangle { vertices: [0, 1, 2], material: 0 }],
                ..Mesh::default()
            }
        };
        let instance = |mesh| Instance { node: 0, mesh, material: Some(mesh), leaf_id: 0, deformation: None };
        Scene {
            nodes: vec![node()],
            cameras: vec![camera],
            materials: layers.iter().map(material).collect(),
            textures: vec![texture],
            meshes: layers.iter().map(mesh).collect(),
            instances: (0..layers.len()).map(instance).collect(),
            ..Scene::default()
        }
    }

    fn lamp(position: DVec3) -> FrozenLight {
        let (intensity, emission, shape) = (Rgb::splat(9.0), Emission::Even, LampShape::NONE);
        FrozenLight::Point { position, intensity, emission, shape }
    }

    fn sun(to_light: DVec3) -> FrozenLight {
        FrozenLight::Sun { to_light: to_light.normalize(), irradiance: Rgb::ONE }
    }

    /// So many layers, one behind the other, each slightly tilted, and thin enough that a ray sees through
    /// all of them.
    fn layers(count: usize) -> Vec<Layer> {
        let layer = |index: usize| {
            let place = index as f64 / count as f64;
            (
                [0.3 * (40.0 * place).sin(), 0.3 * (57.0 * place).cos(), 2.0 * place - 1.0],
                [0.2, 0.3 - 0.6 * place],
                0.005,
            )
        };
        (0..count).map(layer).collect()
    }

    /// Numbers of factors that the sweeps multiply on a ray through so many layers under a lamp: for
    /// surfaces, and for fog.
    fn multiplications(count: usize) -> [usize; 2] {
        let scene = scene(&layers(count), false);
        let trees = MeshTrees::new(&scene);
        let snapshot = Snapshot::new(&scene, &trees, 0, 1.0, Shutter { open_s: 0.0, close_s: 0.0 });
        let ray = Ray { origin: DVec3::ZERO, direction: DVec3::NEG_Z };
        let blended = snapshot.blended_hits(&ray, &(0.0..f64::INFINITY), None);
        assert_eq!(blended.len(), count);
        let position = DVec3::new(1.0, 2.0, -4.0);
        let light = lamp(position);
        let counted = |work: &mut dyn FnMut()| {
            MULTIPLICATIONS.set(0);
            work();
            MULTIPLICATIONS.get()
        };
        let way = Way { distance: f64::INFINITY, blended, passes_hidden: false };
        let mut lit = LitSegments::default();
        lit.start(&ray, &light, (0.0, 20.0));
        [
            counted(&mut || drop(let_through(&snapshot, &ray, &light, &way.blended))),
            counted(&mut || shade(&mut lit, &snapshot, &ray, &light, &way)),
        ]
    }

    /// Eight times as many layers take less than twelve times as many steps; products formed anew at each
    /// surface would take 64 times as many.
    #[test]
    fn steps_grow_as_n_log_n() {
        let [few, many] = [64, 512].map(multiplications);
        for (few, many) in few.into_iter().zip(many) {
            assert!(few >= 64, "{few}");
            assert!(many <= 12 * few, "{few} {many}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn equals_the_shadow_rays(
            layers in prop::collection::vec(layer(), MANY + 1..60), is_textured in any::<bool>(),
        ) {
            let scene = scene(&layers, is_textured);
            let trees = MeshTrees::new(&scene);
            let snapshot = Snapshot::new(&scene, &trees, 0, 1.0, Shutter { open_s: 0.0, close_s: 0.0 });
            let ray = Ray { origin: DVec3::ZERO, direction: DVec3::NEG_Z };
            let blended = snapshot.blended_hits(&ray, &(0.0..f64::INFINITY), None);
            prop_assume!(blended.len() > MANY);
            let lights = [
                sun(DVec3::new(0.3, 1.0, 0.4)),
                sun(DVec3::new(-0.2, 0.5, -1.0)),
                lamp(DVec3::new(1.0, 2.0, -4.0)),
                // Along the ray: from behind, from ahead, from among them.
                sun(DVec3::Z),
                sun(DVec3::NEG_Z),
                lamp(DVec3::new(0.0, 0.0, -5.0)),
            ];
            for light in lights {
                let illumination = Illumination {
                    lights: std::slice::from_ref(&light), has_rest: true,
                    sky: false, is_in_specular: false, indirect_alone: false, branches: Branches::ONE,
                };
                let mut sampler = Sampler::new(0, 0, 0, 0);
                let stack = Stack::of(&snapshot, &illumination, &ray, &blended, &mut sampler);
                let found = stack.map(|stack| stack.scattered).unwrap_or_default();
                for (hit, found) in blended.iter().zip(found) {
                    let expected = direct::scattered(&snapshot, &[light], &hit.point);
                    let off = (found - expected).abs().max_element();
                    prop_assert!(off <= 1e-9 * expected.max_element() + 1e-11, "{found} {expected} {light:?}");
                }
            }
        }

        /// A few represent all: the expected weight of each is 1.
        #[test]
        fn shares_are_one_in_the_mean(layers in prop::collection::vec(layer(), MANY + 1..40)) {
            let scene = scene(&layers, false);
            let trees = MeshTrees::new(&scene);
            let snapshot = Snapshot::new(&scene, &trees, 0, 1.0, Shutter { open_s: 0.0, close_s: 0.0 });
            let ray = Ray { origin: DVec3::ZERO, direction: DVec3::NEG_Z };
            let blended = snapshot.blended_hits(&ray, &(0.0..f64::INFINITY), None);
            const TRIES: usize = 4000;
            let mut sums = vec![0.0; blended.len()];
            for attempt in 0..TRIES {
                let shares = shares(&blended, (attempt as f64 + 0.5) / TRIES as f64);
                prop_assert!(shares.iter().filter(|share| **share > 0.0).count() <= CHOSEN);
                sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share);
            }
            let mut seen_through = 1.0;
            for (hit, sum) in blended.iter().zip(sums) {
                // One choice more or less changes the sum by the weight of one choice.
                let weight = seen_through * hit.point.alpha;
                let error = 2.0 / (weight * TRIES as f64);
                prop_assert!((sum / TRIES as f64 - 1.0).abs() <= error, "{sum}");
                seen_through *= hit.point.see_through.x;
            }
        }
    }
}
