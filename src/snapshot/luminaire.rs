//! A frozen light of any shape. In go uniform numbers, out comes a light without extent. Invariant: the
//! expected irradiance of [`Luminaire::point`] is that of the light, at any place. So results that are exact
//! for lights without extent hold for the others on average.
//!
//! Points do not depend on the place that is lit, so a whole slice of rays may share one.

use crate::color::Rgb;
use crate::light::{Cone, Emission, FrozenLight, LampShape};
use crate::math::disc_from_square;
use crate::scene::{AreaShape, DiscPicture, LampTraits, Light, LightKind, SkySun};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// Half angle of an area light's spread from which it has no grid, radians: pi / 2 in single precision.
const WITHOUT_GRID: f64 = FRAC_PI_2 - 1e-6;

/// Kind of observer of a lamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watcher {
    /// The camera.
    Camera,
    /// Mirrors and other smooth surfaces.
    Mirror,
}

/// A light of any shape at one time, in relative space: a distribution over lights without extent.
#[derive(Clone, Debug)]
pub struct Luminaire {
    pub(super) centre: FrozenLight,
    pub(super) extent: Extent,
    /// Intensity without fog, W/sr, of a lamp that the camera and mirrors see, for each of these.
    shown: [Option<Rgb>; 2],
}

/// Distribution of a light's points around its centre.
#[derive(Clone, Debug)]
pub(super) enum Extent {
    /// No extent.
    None,
    /// Directions of a disc: the sines of its radius along two unit vectors at right angles to its centre.
    Disc { half_axes: [DVec3; 2], picture: Option<Arc<DiscPicture>>, is_visible: bool },
    /// Places within a sphere.
    Ball { radius: f64 },
    /// Places of a parallelogram or of its ellipse, given from the centre to the middles of two edges.
    Flat { shape: AreaShape, half_axes: [DVec3; 2] },
    /// Lights that represent it, each with all of its power.
    Points(Arc<[FrozenLight]>),
}

impl Luminaire {
    /// Freezes `light`.
    pub fn new(light: &Light, relative_from_light: DAffine3, time_s: f64) -> Self {
        let power = light.power.at(time_s);
        let axes = relative_from_light.matrix3;
        let beam = (-axes.z_axis).try_normalize().unwrap_or(DVec3::NEG_Z);
        let position = relative_from_light.translation;
        let shape = LampShape { centre: position, ..LampShape::NONE };
        let point = |intensity: Rgb, emission| FrozenLight::Point { position, intensity, emission, shape };
        let ball = |radius: f64| if radius > 0.0 { Extent::Ball { radius } } else { Extent::None };
        let (centre, extent) = match &light.kind {
            LightKind::Sun => (FrozenLight::Sun { to_light: -beam, irradiance: power }, Extent::None),
            LightKind::SunDisc(disc) => {
                let centre = FrozenLight::Sun { to_light: -beam, irradiance: power };
                let sin_radius = (0.5 * disc.angular_diameter.at(time_s)).sin();
                // As seen from below, facing the sun: right and up.
                let up = (axes.y_axis - axes.y_axis.dot(beam) * beam).try_normalize();
                let up = up.unwrap_or_else(|| beam.any_orthonormal_vector());
                let turn = DVec2::from_angle(disc.picture_rotation.at(time_s));
                let unturned = [up.cross(beam) * sin_radius, up * sin_radius];
                let half_axes = [span(&unturned, turn), span(&unturned, turn.perp())];
                let extent = if sin_radius > 0.0 {
                    let picture = disc.picture.as_ref().and_then(|picture| picture.at(time_s));
                    Extent::Disc { half_axes, picture, is_visible: disc.visible_to_camera }
                } else {
                    Extent::None
                };
                (centre, extent)
            }
            LightKind::Point => (point(power, Emission::Even), Extent::None),
            LightKind::Sphere { radius } => (point(power, Emission::Even), ball(radius.at(time_s))),
            LightKind::Spot { outer_angle, blend, radius } => {
                let cos_outer = outer_angle.at(time_s).cos();
                let cos_inner = cos_outer + (1.0 - cos_outer) * blend.at(time_s);
                let cone = Cone { axis: beam, cos_outer, cos_inner };
                (point(power, Emission::Spot(cone)), ball(radius.at(time_s)))
            }
            LightKind::Area { shape, width, height, spread } => {
                let half_axes = [0.5 * width.at(time_s) * axes.x_axis, 0.5 * height.at(time_s) * axes.y_axis];
                // A sheared light is still flat: its plane counts.
                let normal = half_axes[0].cross(half_axes[1]).try_normalize().unwrap_or(beam);
                let normal = if normal.dot(beam) < 0.0 { -normal } else { normal };
                // Lambert: the power is pi times the intensity along the normal.
                let half_angle = 0.5 * spread.at(time_s);
                let centre = if half_angle < WITHOUT_GRID {
                    let cone = Cone { axis: normal, cos_outer: half_angle.cos(), cos_inner: 1.0 };
                    // Power that the grid would block is added to the rest: the integral over the cone stays
                    // the same.
                    let narrowed = 1.0 - half_angle / half_angle.tan();
                    point(power * FRAC_1_PI / narrowed, Emission::Gridded(cone))
                } else {
                    point(power * FRAC_1_PI, Emission::Flat { normal })
                };
                (centre, Extent::Flat { shape: *shape, half_axes })
            }
        };
        Self { centre, extent, shown: [None; 2] }
    }

    /// A sun in the picture of a sky: it lights only, as the picture shows it.
    pub(super) fn of_sky(sun: &SkySun) -> Self {
        let &SkySun { to_sun, irradiance, angular_diameter } = sun;
        let sin_radius = (0.5 * angular_diameter).sin();
        let (x, y) = to_sun.any_orthonormal_pair();
        let half_axes = [x * sin_radius, y * sin_radius];
        let extent = Extent::Disc { half_axes, picture: None, is_visible: false };
        Self { centre: FrozenLight::Sun { to_light: to_sun, irradiance }, extent, shown: [None; 2] }
    }

    /// Luminaire of many points, each with all of its power.
    pub fn of_points(points: Arc<[FrozenLight]>) -> Option<Self> {
        let &FrozenLight::Point { position, intensity, shape, .. } = points.first()? else { return None };
        let centre = FrozenLight::Point { position, intensity, emission: Emission::Even, shape };
        Some(Self { centre, extent: Extent::Points(points), shown: [None; 2] })
    }

    /// Its points, each with all of its power; none if it has an extent of another kind.
    pub fn points(&self) -> &[FrozenLight] {
        if let Extent::Points(points) = &self.extent { points } else { &[] }
    }

    /// Luminaire with the traits of a lamp.
    pub fn with(mut self, traits: LampTraits) -> Self {
        let FrozenLight::Point { intensity, shape, .. } = &mut self.centre else { return self };
        let area = match &self.extent {
            Extent::Ball { radius } => PI * radius * radius,
            Extent::Flat { half_axes: [right, up], .. } => 4.0 * right.cross(*up).length(),
            _ => return self,
        };
        if let Extent::Ball { radius } = &self.extent {
            let of = |has: bool| if has { radius * radius } else { 0.0 };
            shape.softened_m2 = of(traits.soft_falloff);
            shape.inward_m2 = of(traits.shines_inward && !traits.soft_falloff);
        }
        shape.shown_m2 = if traits.visible_in_mirrors { area } else { 0.0 };
        self.shown = [traits.visible_to_camera, traits.visible_in_mirrors].map(|is| is.then_some(*intensity));
        self
    }

    /// Intensity of a lamp that an observer sees, W/sr.
    pub(super) fn shown_to(&self, watcher: Watcher) -> Option<Rgb> {
        self.shown[watcher as usize]
    }

    /// Whether a specular lobe of an alpha shows it as an image at a place.
    pub fn shows_in(&self, alpha: f64, place: DVec3) -> bool {
        matches!(self.centre, FrozenLight::Point { shape, .. } if shape.shows_in(alpha, place))
    }

    /// Luminaire without power.
    pub fn switched_off(mut self) -> Self {
        self.shown = [None; 2];
        match &mut self.centre {
            FrozenLight::Sun { irradiance: power, .. } | FrozenLight::Point { intensity: power, .. } => {
                *power = Rgb::ZERO;
            }
        }
        self
    }

    /// Luminaire in fog of an extinction, 1/m. A sphere emits at its surface, but its sampled points lie
    /// within, so the fog between is compensated. The disc of soft falloff is at the centre.
    pub fn in_fog(mut self, extinction_per_m: Rgb) -> Self {
        if let (Extent::Ball { radius }, FrozenLight::Point { intensity, shape, .. }) =
            (&self.extent, &mut self.centre)
            && shape.softened_m2 == 0.0
        {
            *intensity *= extinction_per_m.map(|extinction| surface_per_ball(extinction * radius));
        }
        self
    }

    /// Whether it has no extent: every [`Luminaire::point`] is [`Luminaire::centre`].
    pub fn is_delta(&self) -> bool {
        matches!(self.extent, Extent::None)
    }

    /// Radius of a sphere, metres; 0 for all others.
    pub fn radius_m(&self) -> f64 {
        if let Extent::Ball { radius } = self.extent { radius } else { 0.0 }
    }

    /// Whether points differ in their hue, see [`Luminaire::hued_point`].
    pub fn has_hues(&self) -> bool {
        matches!(&self.extent, Extent::Disc { picture: Some(picture), .. } if !picture.is_grey())
    }

    /// The point at its centre: its place as seen from afar. It is not its mean.
    pub fn centre(&self) -> FrozenLight {
        self.centre
    }

    /// The point that three numbers in `[0, 1)` sample; over uniform numbers its mean is the light.
    pub fn point(&self, u: [f64; 3]) -> FrozenLight {
        let (mut point, hue) = self.hued_point(u);
        match &mut point {
            FrozenLight::Sun { irradiance: power, .. } | FrozenLight::Point { intensity: power, .. } => {
                *power *= hue;
            }
        }
        point
    }

    /// Point with the light's mean colour, and its hue: a factor, each channel 1 on average over the light.
    pub fn hued_point(&self, u: [f64; 3]) -> (FrozenLight, Rgb) {
        let in_square = DVec2::new(u[0], u[1]);
        let mut hue = Rgb::ONE;
        let offset = match &self.extent {
            Extent::None => return (self.centre, hue),
            Extent::Points(points) => return (points[(u[0] * points.len() as f64) as usize], hue),
            Extent::Disc { half_axes, picture: None, .. } => span(half_axes, disc_from_square(in_square)),
            Extent::Disc { half_axes, picture: Some(picture), .. } => {
                let place;
                (place, hue) = picture.point(in_square);
                span(half_axes, place)
            }
            Extent::Ball { radius } => *radius * in_ball(u),
            Extent::Flat { shape: AreaShape::Rectangle, half_axes } => span(half_axes, 2.0 * in_square - 1.0),
            Extent::Flat { shape: AreaShape::Ellipse, half_axes } => {
                span(half_axes, disc_from_square(in_square))
            }
        };
        let point = match self.centre {
            FrozenLight::Sun { to_light, irradiance } => {
                // Uniform over the disc's projection along its axis, with the density cos / (pi sin^2) per
                // steradian: on a plane perpendicular to the axis every point gives the same irradiance.
                let cos = (1.0 - offset.length_squared()).max(0.0).sqrt();
                let to_point = (cos * to_light + offset).normalize();
                let irradiance = irradiance / cos.max(f64::MIN_POSITIVE);
                FrozenLight::Sun { to_light: to_point, irradiance }
            }
            FrozenLight::Point { position, intensity, emission, shape } => {
                FrozenLight::Point { position: position + offset, intensity, emission, shape }
            }
        };
        (point, hue)
    }

    /// Whether rays that leave the scene may see it.
    pub fn is_visible(&self) -> bool {
        self.shown[0].is_some() || matches!(self.extent, Extent::Disc { is_visible: true, .. })
    }

    /// Radiance along a ray that leaves the scene in that direction.
    pub fn seen_along(&self, direction: DVec3) -> Rgb {
        let (
            FrozenLight::Sun { to_light, irradiance },
            Extent::Disc { half_axes, picture, is_visible: true },
        ) = (self.centre, &self.extent)
        else {
            return Rgb::ZERO;
        };
        let squared_radius = half_axes[0].length_squared();
        let place = DVec2::new(direction.dot(half_axes[0]), direction.dot(half_axes[1])) / squared_radius;
        if place.length_squared() > 1.0 || direction.dot(to_light) <= 0.0 {
            return Rgb::ZERO;
        }
        let color = picture.as_ref().map_or(Rgb::ONE, |picture| picture.color_at(place));
        irradiance * color / (PI * squared_radius)
    }
}

fn span(axes: &[DVec3; 2], along: DVec2) -> DVec3 {
    along.x * axes[0] + along.y * axes[1]
}

/// Ratio of a sphere's light through fog from its surface to that from the points of [`in_ball`]. `depth` is
/// the optical depth of its radius.
///
/// A chord of half length `h` gives `exp(h)` at its near end, and `I0(h)` averaged over its points, relative
/// to its middle. Over all chords seen from afar these are `2 ((t - 1) exp(t) + 1) / t^2` and `2 I1(t) / t`,
/// here both by their power series.
fn surface_per_ball(depth: f64) -> f64 {
    /// Depth beyond which nothing is transmitted, and the ratio stays constant.
    const MOST: f64 = 30.0;
    /// From this term on `MOST^k / k!` is below the last bit of the sum.
    const TERMS: u32 = 120;
    let t = depth.min(MOST);
    let (mut surface, mut ball, mut power, mut square) = (0.0, 0.0, 1.0, 1.0);
    for k in (0..TERMS).map(f64::from) {
        // t^k / k! and (t^2 / 4)^k / (k! (k + 1)!)
        surface += power / (k + 2.0);
        ball += 0.5 * square;
        power *= t / (k + 1.0);
        square *= 0.25 * t * t / ((k + 1.0) * (k + 2.0));
    }
    surface / ball
}

/// A point of the unit ball, with a density in proportion to `1 / sqrt(1 - r^2)`.
/// Along a line at the distance `b` from the centre that density integrates to `integral ds / sqrt(1 - b^2 -
/// s^2) = pi`, the same for all `b < 1`. So seen from outside, points that emit equally in all directions
/// look together like a sphere of uniform radiance, as one that emits at its surface does. Points on the
/// surface would do as well, each emitting to its own half space; but then half of them would light nothing
/// at any given place.
///
/// It is the density of a uniform point on the sphere in four dimensions, projected to three (Shoemake 1992,
/// "Uniform Random Rotations", for the point).
fn in_ball(u: [f64; 3]) -> DVec3 {
    let (inner, outer) = ((1.0 - u[0]).sqrt(), u[0].sqrt());
    (inner * DVec2::from_angle(TAU * u[1])).extend(outer * (TAU * u[2]).sin())
}
