//! Lights, and aimed motions. In go fields of a file, out come lights at nodes. Invariant: an aimed node is
//! never at its target.

use super::{Resolver, track};
use crate::description::ron::{self, Animated, Keyable, Point};
use crate::scene::{Animate, AreaShape, Light, LightKind, Motion, Rotation, Track};
use glam::{DQuat, DVec3};
use std::f64::consts::PI;

/// Points of a field, after its name.
pub(super) type Field<'a> = (&'a str, &'a Animated<Point>);

impl Resolver<'_> {
    pub(super) fn lights(&mut self) {
        for (name, light) in self.file.lights.iter() {
            let owner = format!("lights.{name}");
            let (motion, (field, power), kind) = match light {
                ron::Light::Sun(sun) => (
                    self.sun_motion(&owner, sun.direction.as_ref(), sun.to_sun.as_ref()),
                    ("irradiance_w_per_m2", &sun.irradiance_w_per_m2),
                    self.sun(&owner, sun),
                ),
                ron::Light::Point { position_m, intensity_w_per_sr, radius_m, .. } => (
                    self.keyed(&owner, "position_m", position_m).map(unturned),
                    ("intensity_w_per_sr", intensity_w_per_sr),
                    self.keyed(&owner, "radius_m", radius_m).map(point),
                ),
                ron::Light::Spot { position_m, target_m, intensity_w_per_sr, .. } => (
                    // A cone of light looks the same for any up direction.
                    self.aimed_light(&owner, position_m, target_m, DVec3::Y),
                    ("intensity_w_per_sr", intensity_w_per_sr),
                    self.spot(&owner, light),
                ),
                ron::Light::Rectangle { position_m, target_m, up, width_m, height_m, power_w, .. } => {
                    let motion = self.aimed_light(&owner, position_m, target_m, up.0);
                    let width = self.keyed(&owner, "width_m", width_m);
                    let sides = width.zip(self.keyed(&owner, "height_m", height_m));
                    let kind = sides.map(|(width, height)| area(AreaShape::Rectangle, width, height));
                    (motion, ("power_w", power_w), kind)
                }
                ron::Light::Disc { position_m, target_m, diameter_m, power_w, .. } => (
                    self.aimed_light(&owner, position_m, target_m, DVec3::Y),
                    ("power_w", power_w),
                    self.keyed(&owner, "diameter_m", diameter_m)
                        .map(|diameter| area(AreaShape::Ellipse, diameter.clone(), diameter)),
                ),
            };
            let power = self.keyed(&owner, field, power);
            let parent = self.parent(&owner, parent_of(light));
            if let (Some(parent), Some(motion), Some(power), Some(kind)) = (parent, motion, power, kind) {
                let node = self.scene.add_node(name.to_owned(), parent, motion);
                self.scene.lights.push(Light { name: name.to_owned(), node, power, kind });
            }
        }
    }

    fn spot(&mut self, owner: &str, light: &ron::Light) -> Option<LightKind> {
        let ron::Light::Spot { outer_deg, blend, radius_m, .. } = light else { return None };
        let outer_angle = self.keyed(owner, "outer_deg", outer_deg);
        let blend = self.keyed(owner, "blend", blend);
        let radius = self.keyed(owner, "radius_m", radius_m);
        Some(LightKind::Spot { outer_angle: outer_angle?, blend: blend?, radius: radius? })
    }

    fn aimed_light(
        &mut self,
        owner: &str,
        position_m: &Animated<Point>,
        target_m: &Animated<Point>,
        up: DVec3,
    ) -> Option<Motion> {
        self.aimed(owner, ("position_m", position_m), ("target_m", target_m), up.into())
    }

    /// Track of a field.
    pub(super) fn keyed<T: Keyable<Si: Animate>>(
        &mut self,
        owner: &str,
        name: &str,
        value: &Animated<T>,
    ) -> Option<Track<T::Si>> {
        track(value, &format!("{owner}.{name}"), &mut self.problems)
    }

    /// Motion of a sun from `position` towards `target`; only the direction matters.
    fn sun_motion(
        &mut self,
        owner: &str,
        direction: Option<&Animated<ron::Direction>>,
        to_sun: Option<&Animated<ron::Direction>>,
    ) -> Option<Motion> {
        let here = || Track::from(DVec3::ZERO);
        let (position, target) = match (direction, to_sun) {
            (Some(direction), None) => (here(), self.keyed(owner, "direction", direction)?),
            (None, Some(to_sun)) => (self.keyed(owner, "to_sun", to_sun)?, here()),
            (both, _) => {
                let found = if both.is_some() { "given twice" } else { "missing" };
                self.problems.error(
                    owner,
                    format!("the sun's direction is {found}"),
                    "either `direction`, where the light goes to, or `to_sun`, where it comes from",
                    "write one of the two",
                );
                return None;
            }
        };
        Some(Motion::Aimed { position, target, up: DVec3::Y.into() })
    }

    /// Motion at one field's value, with -Z towards another's.
    pub(super) fn aimed(
        &mut self,
        owner: &str,
        (from, position): Field,
        (to, target): Field,
        up: Track<DVec3>,
    ) -> Option<Motion> {
        let (position, target) = (self.keyed(owner, from, position), self.keyed(owner, to, target));
        let (position, target) = (position?, target?);
        let times_s = [position.times_s(), target.times_s()].concat();
        let mut times = times_s.into_iter();
        if let Some(time_s) = times.find(|&time_s| position.at(time_s) == target.at(time_s)) {
            self.problems.error(
                &format!("{owner}.{to}"),
                format!("`{from}` and `{to}` are the same point at {time_s} s"),
                "two different points",
                "move one of them",
            );
            return None;
        }
        Some(Motion::Aimed { position, target, up })
    }
}

fn parent_of(light: &ron::Light) -> Option<&str> {
    match light {
        ron::Light::Sun(ron::Sun { parent, .. })
        | ron::Light::Point { parent, .. }
        | ron::Light::Spot { parent, .. }
        | ron::Light::Rectangle { parent, .. }
        | ron::Light::Disc { parent, .. } => parent.as_deref(),
    }
}

fn unturned(translation: Track<DVec3>) -> Motion {
    Motion::Keyed {
        translation,
        rotation: Rotation::Quaternion(DQuat::IDENTITY.into()),
        scale: DVec3::ONE.into(),
    }
}

fn area(shape: AreaShape, width: Track<f64>, height: Track<f64>) -> LightKind {
    LightKind::Area { shape, width, height, spread: Track::from(PI) }
}

fn point(radius: Track<f64>) -> LightKind {
    if is_always_zero(&radius) { LightKind::Point } else { LightKind::Sphere { radius } }
}

pub(super) fn is_always_zero(size: &Track<f64>) -> bool {
    size.is_constant() && size.at(0.0) == 0.0
}
