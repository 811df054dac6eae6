//! The slow truth about light in fog: optical depth by clipping, the scattered light by adaptive
//! quadrature over the distance itself. In go the scene's boxes and lit intervals, out comes radiance.

use glam::{DAffine3, DVec3};
use std::f64::consts::PI;
use sunfleck::color::Rgb;
use sunfleck::math::{IntervalSet, Ray, gauss_legendre};
use sunfleck::scene::Fog;
use sunfleck::snapshot::{Emission, FrozenLight};

/// Wanted relative error of the quadrature.
const TOLERANCE: f64 = 1e-10;

/// Part of the model: a near light closer to a ray than this fraction of its distance counts as that far
/// from it (docs/decisions/exactness.md).
const SMALLEST_RELATIVE_GAP: f64 = 1e-7;

/// All boxes of fog.
pub(crate) struct FogTruth {
    boxes: Vec<FogBox>,
}

struct FogBox {
    cube_from_relative: DAffine3,
    sigma_t: Rgb,
    sigma_s: Rgb,
    g: f64,
}

impl FogTruth {
    /// The scene's fog at time 0, with places relative to the camera.
    pub(crate) fn new<'a>(fogs: impl Iterator<Item = (&'a Fog, DAffine3)>) -> Self {
        let freeze = |(fog, relative_from_cube): (&Fog, DAffine3)| FogBox {
            cube_from_relative: relative_from_cube.inverse(),
            sigma_t: fog.density_per_m.at(0.0),
            sigma_s: fog.density_per_m.at(0.0) * fog.albedo.at(0.0),
            g: fog.anisotropy.at(0.0),
        };
        // A flat box holds nothing.
        let has_room =
            |(_, relative_from_cube): &(&Fog, DAffine3)| relative_from_cube.matrix3.determinant() != 0.0;
        Self { boxes: fogs.filter(has_room).map(freeze).collect() }
    }

    /// Beer and Lambert along `origin + t * direction`, `0 < t < end`.
    pub(crate) fn transmittance(&self, origin: DVec3, direction: DVec3, end: f64) -> Rgb {
        let depth = |fog: &FogBox| {
            let (enter, leave) = fog.span(origin, direction);
            fog.sigma_t * (leave.min(end) - enter.max(0.0)).max(0.0)
        };
        let tau: Rgb = self.boxes.iter().map(depth).sum();
        Rgb::from_array(tau.to_array().map(|tau| (-tau).exp()))
    }

    /// Light that a metre of fog at `t` sends to the ray's origin.
    fn scattered_at(&self, ray: &Ray, t: f64, light: &FrozenLight) -> Rgb {
        let point = ray.at(t);
        let (to_light, distance, _) = light.arriving_at(point);
        let (arriving, cos) = kept_apart(ray, t, light);
        let scatters = |fog: &&FogBox| {
            let (enter, leave) = fog.span(ray.origin, ray.direction);
            enter < t && t < leave
        };
        let scattering: Rgb = self
            .boxes
            .iter()
            .filter(scatters)
            .map(|fog| {
                // 1 + g^2 - 2 g cos, without cancelling for g near 1.
                let spread = (1.0 - fog.g).powi(2) + 2.0 * fog.g * (1.0 - cos);
                fog.sigma_s * (1.0 - fog.g * fog.g) / (4.0 * PI * spread.powf(1.5))
            })
            .sum();
        scattering
            * arriving
            * self.transmittance(point, to_light, distance)
            * self.transmittance(ray.origin, ray.direction, t)
    }
}

impl FogBox {
    /// The part of the line inside, as a range of `t`; empty if it misses.
    fn span(&self, origin: DVec3, direction: DVec3) -> (f64, f64) {
        self.span_and_faces(origin, direction).0
    }

    /// The same, and which pairs of faces the line enters and leaves by.
    fn span_and_faces(&self, origin: DVec3, direction: DVec3) -> ((f64, f64), (usize, usize)) {
        let origin = self.cube_from_relative.transform_point3(origin);
        let direction = self.cube_from_relative.transform_vector3(direction);
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut faces = (3, 3);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if origin[axis].abs() > 1.0 {
                    return ((0.0, 0.0), (3, 3));
                }
                continue;
            }
            let [a, b] = [-1.0, 1.0].map(|face| (face - origin[axis]) / direction[axis]);
            if a.min(b) > enter {
                (enter, faces.0) = (a.min(b), axis);
            }
            if a.max(b) < leave {
                (leave, faces.1) = (a.max(b), axis);
            }
        }
        ((enter, leave), faces)
    }

    /// Which way the light takes through the box to `ray.at(t)`, as far as its length changes smoothly.
    fn way(&self, ray: &Ray, t: f64, light: &FrozenLight) -> Option<(Option<usize>, Option<usize>)> {
        let (to_light, distance, _) = light.arriving_at(ray.at(t));
        let ((enter, leave), faces) = self.span_and_faces(ray.at(t), to_light);
        let meets = enter.max(0.0) < leave.min(distance);
        meets.then_some(((enter > 0.0).then_some(faces.0), (leave < distance).then_some(faces.1)))
    }
}

/// What a light that counts as farther away than it is sends to `ray.at(t)`, and the
/// cosine of its deflection.
fn kept_apart(ray: &Ray, t: f64, light: &FrozenLight) -> (Rgb, f64) {
    let (to_light, _, arriving) = light.arriving_at(ray.at(t));
    let FrozenLight::Point { position, .. } = light else { return (arriving, to_light.dot(ray.direction)) };
    let way = *position - ray.origin;
    let ahead = way.dot(ray.direction) - t;
    let gap = ray.direction.cross(way).length();
    let least = SMALLEST_RELATIVE_GAP * way.length();
    if gap >= least {
        return (arriving, to_light.dot(ray.direction));
    }
    let (near, far) = (ahead.hypot(gap), ahead.hypot(least));
    (arriving * (near / far).powi(2), ahead / far)
}

/// Light scattered into the ray between 0 and `end`, where it is not in shadow.
pub(crate) fn integral(
    fog: &FogTruth,
    ray: &Ray,
    light: &FrozenLight,
    shadows: &IntervalSet,
    end: f64,
) -> Rgb {
    let mut cuts: Vec<f64> = Vec::new();
    for fog in &fog.boxes {
        let (enter, leave) = fog.span(ray.origin, ray.direction);
        if enter < leave {
            cuts.extend([enter.clamp(0.0, end), leave.clamp(0.0, end)]);
        }
    }
    let (Some(first), Some(last)) =
        (cuts.iter().copied().reduce(f64::min), cuts.iter().copied().reduce(f64::max))
    else {
        return Rgb::ZERO;
    };
    if let FrozenLight::Point { position, emission, .. } = light {
        // The inverse square has structure at every scale around the nearest point.
        let nearest = (*position - ray.origin).dot(ray.direction);
        let gap = ray.at(nearest).distance(*position).max(1e-12 * position.length()).max(1e-15);
        cuts.push(nearest);
        for power in 0..60 {
            let offset = gap * 3_f64.powi(power);
            cuts.extend([nearest - offset, nearest + offset]);
        }
        cuts.extend(share_changes(ray, *position, emission));
    }
    for fog in &fog.boxes {
        let way = |t: f64| fog.way(ray, t, light);
        cuts.extend(changes(way, (0..=1000).map(|index| first + (last - first) * f64::from(index) / 1000.0)));
    }
    cuts.retain(|cut| *cut >= first && *cut <= last);
    cuts.sort_by(f64::total_cmp);
    cuts.extend(beside_cuts_in_the_dark(fog, &cuts));
    cuts.sort_by(f64::total_cmp);
    quadrature(&|t: f64| fog.scattered_at(ray, t, light), &cuts, shadows)
}

/// Between cuts the light is brightest at one of them; in thick fog the rule's first node
/// would see none of it.
fn beside_cuts_in_the_dark(fog: &FogTruth, cuts: &[f64]) -> Vec<f64> {
    let densest: Rgb = fog.boxes.iter().map(|fog| fog.sigma_t).sum();
    let dark = cuts.windows(2).filter(|pair| densest.max_element() * (pair[1] - pair[0]) > 30.0);
    let beside = |pair: &[f64]| {
        [4_f64.powi(-3), 4_f64.powi(-6)].map(|share| {
            let width = share * (pair[1] - pair[0]);
            [pair[0] + width, pair[1] - width]
        })
    };
    dark.flat_map(beside).flatten().collect()
}

/// Over what shadows leave, on pieces between cuts.
pub(crate) fn quadrature(value: &impl Fn(f64) -> Rgb, cuts: &[f64], shadows: &IntervalSet) -> Rgb {
    let pieces = |handle: &mut dyn FnMut(f64, f64)| {
        for pair in cuts.windows(2) {
            shadows.for_each_gap(pair[0], pair[1], &mut *handle);
        }
    };
    let mut rough = Rgb::ZERO;
    pieces(&mut |start, end| rough += rule(value, start, end));
    let mut sum = Rgb::ZERO;
    pieces(&mut |start, end| {
        let whole = rule(value, start, end);
        sum += refine(value, (start, end), whole, TOLERANCE * rough.max_element(), 60);
    });
    sum
}

/// Where the light begins to give none or all of its intensity.
fn share_changes(ray: &Ray, light: DVec3, emission: &Emission) -> Vec<f64> {
    let nearest = (light - ray.origin).dot(ray.direction);
    let gap = ray.at(nearest).distance(light);
    let at = |index: i32| nearest + gap * (f64::from(index) / 1000.5 * 0.5 * PI).tan();
    let kind = |t: f64| {
        let share = emission.share((ray.at(t) - light).normalize());
        (share == 0.0, share == 1.0)
    };
    changes(kind, (-1000..=1000).map(at))
}

/// Where a function changes between the points of a grid: by bisection, no formula to share a mistake with.
fn changes<T: PartialEq>(function: impl Fn(f64) -> T, grid: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut changes = Vec::new();
    let mut before: Option<(f64, T)> = None;
    for t in grid {
        let value = function(t);
        if let Some((mut low, at_low)) = before
            && at_low != value
        {
            let mut high = t;
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if function(middle) == at_low { low = middle } else { high = middle }
            }
            changes.push(low);
        }
        before = Some((t, value));
    }
    changes
}

fn rule(value: &impl Fn(f64) -> Rgb, start: f64, end: f64) -> Rgb {
    let half = 0.5 * (end - start);
    let nodes = gauss_legendre(8).iter();
    nodes.map(|(x, weight)| half * *weight * value(start + half * (1.0 + x))).sum()
}

/// Halves until halving changes nothing.
fn refine(
    value: &impl Fn(f64) -> Rgb,
    (start, end): (f64, f64),
    whole: Rgb,
    tolerance: f64,
    depth: u32,
) -> Rgb {
    let middle = 0.5 * (start + end);
    let (left, right) = (rule(value, start, middle), rule(value, middle, end));
    let error = (left + right - whole).abs().max_element();
    assert!(error.is_finite(), "the truth itself is not a number between {start} and {end}");
    // Smaller numbers than the smallest normal one have no digits to agree in.
    let tolerated = tolerance.max(TOLERANCE * (left + right).max_element()).max(f64::MIN_POSITIVE);
    if depth == 0 || error <= tolerated {
        return left + right;
    }
    refine(value, (start, middle), left, tolerance, depth - 1)
        + refine(value, (middle, end), right, tolerance, depth - 1)
}
