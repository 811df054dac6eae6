//! Heights of levels between which unbounded fog is nearly uniform. In go banks of fog and a ground, out come
//! levels from the top down. Invariant: layers have equal optical depths, and dense fog has thin layers.

use super::ground::Ground;
use crate::canopy::emitter_rays::mean_irradiance;
use crate::canopy::first_collisions::mean_times;
use crate::canopy::fluence::Peak;
use crate::color::Rgb;
use crate::fog::{BEAM_DEGREES, Medium, exp_minus};
use crate::ordinates::{Beam, DEGREES, Level, Species, Stack};
use crate::scene::Bounces;
use crate::snapshot::{FrozenLight, Snapshot};
use glam::{DQuat, DVec3};

/// Number of layers of equal optical depth.
const LAYERS: usize = 48;
/// Number of times that the topmost layer is halved: fog that thins out has no top.
const HALVINGS: usize = 6;
/// Optical depth of the layers where no ground ends the fog; below it the medium is semi-infinite.
const DEEPEST: f64 = 6.0;
/// Height above the ground at which no fog is left, in scale heights.
const HIGHEST: f64 = 2e3;
/// Height above a level at which it has its fog, in scale heights: a slab ends on the ground.
const WITHIN: f64 = 1e-6;
/// Maximum deviation between directions in which banks thin out together.
const SAME: f64 = 1e-9;

/// Heights of levels.
pub(super) struct Heights {
    /// Rotation after which fog thins out along +Y.
    pub(super) layers_from_world: DQuat,
    pub(super) up: DVec3,
    has_ground: bool,
    /// Extinction, summed over channels, 1/m, by level.
    extinctions_per_m: Vec<f64>,
    /// Heights from the top down, along `up` from the world's origin, metres.
    heights_m: Vec<f64>,
    /// Scale height of the bank that changes fastest, metres.
    pub(super) scale_m: f64,
    /// Fog of the layers.
    medium: Medium,
}

/// Layers in the form of the solver.
pub(super) struct Filled {
    pub(super) stack: Stack,
    pub(super) beams: Vec<Beam>,
    /// Forward peak of each sun at each level.
    pub(super) peaks: Vec<Vec<Peak>>,
}

/// The levels above and below a place, and the weight of the one below.
#[derive(Clone, Copy)]
pub(super) struct Between {
    pub(super) above: usize,
    pub(super) below: usize,
    pub(super) share_below: f64,
}

impl Heights {
    /// Heights of levels in fog, relative to an eye; `None` unless it thins out in one direction.
    pub(super) fn of(medium: Medium, eye: DVec3, ground: Option<&Ground>) -> Option<Self> {
        let layers: Vec<(DVec3, f64)> = medium.banks().iter().filter_map(|bank| bank.layer()).collect();
        let &(up, _) = layers.first()?;
        if layers.iter().any(|(other, _)| other.dot(up) < 1.0 - SAME) {
            return None;
        }
        let scale_m = layers.iter().map(|(_, scale_m)| *scale_m).fold(f64::INFINITY, f64::min);
        let widest_m = layers.iter().map(|(_, scale_m)| *scale_m).fold(0.0, f64::max);
        let depth_above = |height_m: f64| {
            let point = (height_m - eye.dot(up)) * up;
            medium.optical_depth(point, up, f64::INFINITY).max_element()
        };
        let reach = HIGHEST * widest_m;
        let middle = ground.map_or(eye.dot(up), |ground| ground.height_m);
        let at_depth =
            |depth: f64| bisected((middle - reach, middle + reach), |height| depth_above(height) > depth);
        let lowest_m = ground.map_or_else(|| at_depth(DEEPEST), |ground| ground.height_m);
        let all = depth_above(lowest_m);
        if !(all > 0.0 && all.is_finite()) {
            return None;
        }
        let of_layer = all / LAYERS as f64;
        let top = (0..HALVINGS).rev().map(|halving| of_layer * 0.5_f64.powi(halving as i32 + 1));
        let depths = top.chain((1..LAYERS).map(|layer| layer as f64 * of_layer));
        let heights_m: Vec<f64> = depths.map(at_depth).chain([lowest_m]).collect();
        let extinction_at = |height_m: &f64| {
            let point = (height_m - eye.dot(up) + WITHIN * scale_m) * up;
            medium.extinction_at(point).element_sum()
        };
        let extinctions_per_m = heights_m.iter().map(extinction_at).collect();
        let layers_from_world = DQuat::from_rotation_arc(up, DVec3::Y);
        Some(Self {
            layers_from_world,
            up,
            has_ground: ground.is_some(),
            extinctions_per_m,
            heights_m,
            scale_m,
            medium,
        })
    }

    /// Extinction at a place in world space, summed over channels, 1/m.
    pub(super) fn extinction_per_m(&self, world: DVec3) -> f64 {
        let Between { above, below, share_below } = self.between(world);
        let [above, below] = [above, below].map(|level| self.extinctions_per_m[level]);
        above + share_below * (below - above)
    }

    /// Height of a place in world space, metres.
    pub(super) fn height_m(&self, world: DVec3) -> f64 {
        self.up.dot(world)
    }

    /// Height of the ground, if there is any.
    pub(super) fn ground_m(&self) -> Option<f64> {
        self.heights_m.last().copied().filter(|_| self.has_ground)
    }

    pub(super) fn between(&self, world: DVec3) -> Between {
        let height_m = self.height_m(world);
        let below = self.heights_m.partition_point(|level| *level > height_m);
        let last = self.heights_m.len() - 1;
        if below == 0 || below > last {
            return Between { above: below.min(last), below: below.min(last), share_below: 0.0 };
        }
        let (high, low) = (self.heights_m[below - 1], self.heights_m[below]);
        Between { above: below - 1, below, share_below: (high - height_m) / (high - low) }
    }

    /// Reflectance of the fog below the last level, if no ground ends it: that of a semi-infinite medium, by
    /// its similarity parameter (van de Hulst 1980, "Multiple Light Scattering", chapter 14).
    pub(super) fn reflectance_beneath(&self, snapshot: &Snapshot) -> Rgb {
        let lowest_m = self.heights_m.last().copied().unwrap_or_default();
        let point = (lowest_m - snapshot.view.eye.dot(self.up)) * self.up;
        let (extinction, [all, forwards]) = self.medium.coefficients_at::<2>(point);
        let (all, forwards) = (per(all, extinction), per(forwards, extinction));
        let of_channel = |channel: usize| {
            let left = (1.0 - all[channel]).max(0.0);
            let similarity = (left / (1.0 - forwards[channel]).max(f64::MIN_POSITIVE)).sqrt().min(1.0);
            (1.0 - similarity) * (1.0 - 0.139 * similarity) / (1.0 + 1.17 * similarity)
        };
        Rgb::new(of_channel(0), of_channel(1), of_channel(2))
    }

    /// Layers with fog, and the suns that shine through it.
    pub(super) fn filled(&self, snapshot: &Snapshot, bounces: Bounces) -> Filled {
        let medium = &self.medium;
        let is_delta_scaled = bounces == Bounces::All;
        let without =
            |degree: i32| if is_delta_scaled { medium.without_peaks(degree) } else { medium.clone() };
        let (swept, of_suns) = (without(DEGREES as i32), without(BEAM_DEGREES));
        let eye = snapshot.view.eye;
        let points: Vec<DVec3> =
            self.heights_m.iter().map(|height_m| (height_m - eye.dot(self.up)) * self.up).collect();
        let level = |(number, &point): (usize, &DVec3)| {
            let within = point + WITHIN * self.scale_m * self.up;
            let extinction = swept.extinction_at(within);
            let albedo = |bank: &Medium| per(bank.coefficients_at::<1>(within).1[0], extinction);
            let beneath = self.heights_m.get(number + 1).map_or(0.0, |next| self.heights_m[number] - next);
            Level {
                albedos: medium.each().map(|bank| albedo(&bank)).collect(),
                depth_beneath: swept.optical_depth(point, -self.up, beneath),
            }
        };
        let levels = points.iter().enumerate().map(level).collect();
        let species = medium.banks().iter().map(|bank| species(bank.g, is_delta_scaled)).collect();
        let (mut beams, mut peaks) = (Vec::new(), Vec::new());
        for light in &snapshot.lights {
            let FrozenLight::Sun { to_light, .. } = light.centre() else { continue };
            if to_light.dot(self.up) <= 0.0 {
                continue;
            }
            let irradiance = mean_irradiance(light);
            let arriving = |through: &Medium| -> Vec<Rgb> {
                let dimmed = |point: &DVec3| {
                    irradiance * exp_minus(through.optical_depth(*point, to_light, f64::INFINITY))
                };
                points.iter().map(dimmed).collect()
            };
            let (all, straight) = (arriving(&of_suns), arriving(medium));
            let peak = |(all, straight): (&Rgb, &Rgb)| {
                let irradiance = *all - *straight;
                let times = mean_times(irradiance.element_sum() as f32, all.element_sum() as f32);
                Peak { travel: -to_light, irradiance, times: f64::from(times) }
            };
            peaks.push(all.iter().zip(&straight).map(peak).collect());
            beams.push(Beam { travel: self.layers_from_world * -to_light, irradiances: all });
        }
        Filled { stack: Stack { species, levels }, beams, peaks }
    }
}

/// Ratio by channel; 0 where both are 0.
fn per(color: Rgb, extinction: Rgb) -> Rgb {
    let share =
        |channel: usize| if extinction[channel] > 0.0 { color[channel] / extinction[channel] } else { 0.0 };
    Rgb::new(share(0), share(1), share(2))
}

/// Henyey-Greenstein phase function, with delta-M where all orders are computed.
fn species(g: f64, is_delta_scaled: bool) -> Species {
    let peak = |degrees: usize| if is_delta_scaled { g.max(0.0).powi(degrees as i32) } else { 0.0 };
    let kept = |degree: usize, degrees: usize| {
        if degree < degrees { g.powi(degree as i32) - peak(degrees) } else { 0.0 }
    };
    Species {
        orders: std::array::from_fn(|degree| kept(degree, DEGREES)),
        first: std::array::from_fn(|degree| kept(degree, BEAM_DEGREES as usize)),
    }
}

/// The largest value of a range up to which `holds` is true.
fn bisected((mut low, mut high): (f64, f64), holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}
