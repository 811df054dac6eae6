//! The sky at one time. In go directions and uniform numbers, out come radiances, directions and densities.
//! Invariant: directions are those of relative space, with the sky's rotation included.

use crate::color::Rgb;
use crate::scene::{Sky, SkyLight};
use glam::{DVec2, DVec3};

/// A sky, frozen.
#[derive(Clone, Copy, Debug)]
pub struct FrozenSky<'scene> {
    sky: &'scene Sky,
    strength: Rgb,
    /// Cosine and sine of its rotation about +Y.
    turn: DVec2,
}

impl<'scene> FrozenSky<'scene> {
    /// Freezes `sky`; `None` if it is dark at that time.
    pub(super) fn new(sky: &'scene Sky, time_s: f64) -> Option<Self> {
        let (strength, turn) = (sky.strength.at(time_s), DVec2::from_angle(sky.rotation.at(time_s)));
        (strength.max_element() > 0.0).then_some(Self { sky, strength, turn })
    }

    /// Its values that change with time: strength, and cosine and sine of the rotation.
    pub(super) fn turned_by(&self) -> (Rgb, DVec2) {
        (self.strength, self.turn)
    }

    /// Radiance seen in a direction, W m^-2 sr^-1.
    pub fn along(&self, direction: DVec3) -> Rgb {
        self.strength * self.sky.along(self.before_turn(direction))
    }

    /// Radiance in a direction, without suns that are lights of their own, W m^-2 sr^-1.
    pub fn along_beside_suns(&self, direction: DVec3) -> Rgb {
        self.strength * self.sky.along_beside_suns(self.before_turn(direction))
    }

    /// Radiance around a direction, without suns that are lights of their own, W m^-2 sr^-1. Where a small
    /// part has much of the light, its mean over a cell: a point would miss that part.
    pub fn around(&self, direction: DVec3) -> Rgb {
        let direction = self.before_turn(direction);
        let is_smooth = !self.sky.has_sun();
        let radiance =
            if is_smooth { self.sky.along_beside_suns(direction) } else { self.sky.mean_around(direction) };
        self.strength * radiance
    }

    /// Mean radiances, without suns, of cells of equal solid angle, with the directions of their centres.
    pub fn means(&self) -> impl Iterator<Item = (DVec3, Rgb)> {
        let (turn, strength) = (self.turn, self.strength);
        self.sky.means().map(move |(direction, mean)| (turned(direction, turn), strength * mean))
    }

    /// Whether much of its light comes from a small part of it.
    pub fn has_sun(&self) -> bool {
        self.sky.has_sun()
    }

    /// Whether camera rays see it.
    pub fn is_seen(&self) -> bool {
        self.sky.visible_to_camera
    }

    /// Whether it lights surfaces.
    pub fn lights_surfaces(&self) -> bool {
        self.sky.lights != SkyLight::Nothing
    }

    /// Whether it lights the fog.
    pub fn lights_fog(&self) -> bool {
        self.sky.lights == SkyLight::SurfacesAndFog
    }

    /// The direction that two uniform numbers sample, with about the density of its radiance; `None` if it is
    /// uniform.
    pub fn sample(&self, u: DVec2) -> Option<DVec3> {
        self.sky.sample(u).map(|direction| turned(direction, self.turn))
    }

    /// Probability density of [`FrozenSky::sample`] for a direction, 1/sr; 0 if it samples none.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        self.sky.pdf(self.before_turn(direction))
    }

    /// Whether [`FrozenSky::sample`] samples directions.
    pub fn is_uneven(&self) -> bool {
        self.sky.is_uneven()
    }

    fn before_turn(&self, direction: DVec3) -> DVec3 {
        turned(direction, DVec2::new(self.turn.x, -self.turn.y))
    }
}

/// A direction rotated about +Y; `turn` is the cosine and the sine of the angle.
fn turned(direction: DVec3, turn: DVec2) -> DVec3 {
    // Anticlockwise from above: +Z goes towards +X.
    let DVec2 { x, y } = DVec2::new(direction.z, direction.x).rotate(turn);
    DVec3::new(y, direction.y, x)
}
