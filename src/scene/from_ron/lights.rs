//! Lights in, lights at nodes out; and everything else that is aimed. Invariant: what is aimed is
//! never where it points.

use super::{Resolver, track};
use crate::description::ron::{self, Keyed, NonNegative, Point, Triple};
use crate::scene::{Light, LightKind, Motion, Rotation, Track};
use glam::{DQuat, DVec3};

impl Resolver<'_> {
    /// Places all lights.
    pub(super) fn lights(&mut self) {
        for (name, light) in self.file.lights.iter() {
            let owner = format!("lights.{name}");
            let (parent, motion, power, kind) = match light {
                ron::Light::Sun { parent, direction, to_sun, irradiance_w_per_m2 } => (
                    parent,
                    self.sun_motion(&owner, direction.as_ref(), to_sun.as_ref()),
                    self.power(&owner, "irradiance_w_per_m2", irradiance_w_per_m2),
                    Some(LightKind::Sun),
                ),
                ron::Light::Point { parent, position_m, intensity_w_per_sr } => {
                    let position = track(position_m, &format!("{owner}.position_m"), &mut self.problems);
                    let motion = position.map(|translation| Motion::Keyed {
                        translation,
                        rotation: Rotation::Quaternion(DQuat::IDENTITY.into()),
                        scale: DVec3::ONE.into(),
                    });
                    let power = self.power(&owner, "intensity_w_per_sr", intensity_w_per_sr);
                    (parent, motion, power, Some(LightKind::Point))
                }
                ron::Light::Spot { parent, position_m, target_m, outer_deg, blend, intensity_w_per_sr } => {
                    let outer_angle = track(outer_deg, &format!("{owner}.outer_deg"), &mut self.problems);
                    let blend = track(blend, &format!("{owner}.blend"), &mut self.problems);
                    let kind = outer_angle
                        .zip(blend)
                        .map(|(outer_angle, blend)| LightKind::Spot { outer_angle, blend });
                    // What is up does not show in a cone of light.
                    let motion =
                        self.aimed(&owner, ("position_m", position_m), ("target_m", target_m), DVec3::Y);
                    (parent, motion, self.power(&owner, "intensity_w_per_sr", intensity_w_per_sr), kind)
                }
            };
            let parent = self.parent(&owner, parent.as_deref());
            if let (Some(parent), Some(motion), Some(power), Some(kind)) = (parent, motion, power, kind) {
                let node = self.node(name.to_owned(), parent, motion);
                self.scene.lights.push(Light { name: name.to_owned(), node, power, kind });
            }
        }
    }

    fn power(&mut self, owner: &str, name: &str, power: &Keyed<Triple<NonNegative>>) -> Option<Track<DVec3>> {
        track(power, &format!("{owner}.{name}"), &mut self.problems)
    }

    /// The sun shines from where `position` is to where `target` is; only the direction counts.
    fn sun_motion(
        &mut self,
        owner: &str,
        direction: Option<&Keyed<ron::Direction>>,
        to_sun: Option<&Keyed<ron::Direction>>,
    ) -> Option<Motion> {
        let here = || Track::from(DVec3::ZERO);
        let (position, target) = match (direction, to_sun) {
            (Some(direction), None) => {
                (here(), track(direction, &format!("{owner}.direction"), &mut self.problems)?)
            }
            (None, Some(to_sun)) => (track(to_sun, &format!("{owner}.to_sun"), &mut self.problems)?, here()),
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
        Some(Motion::Aimed { position, target, up: DVec3::Y })
    }

    /// A motion that stands at one field's value and points to another's.
    pub(super) fn aimed(
        &mut self,
        owner: &str,
        (position_name, position): (&str, &Keyed<Point>),
        (target_name, target): (&str, &Keyed<Point>),
        up: DVec3,
    ) -> Option<Motion> {
        let position = track(position, &format!("{owner}.{position_name}"), &mut self.problems);
        let target = track(target, &format!("{owner}.{target_name}"), &mut self.problems);
        let (position, target) = (position?, target?);
        let times = position.keys().iter().chain(target.keys()).map(|key| key.time_s);
        if let Some(time_s) = times.into_iter().find(|&time_s| position.at(time_s) == target.at(time_s)) {
            self.problems.error(
                &format!("{owner}.{target_name}"),
                format!("`{position_name}` and `{target_name}` are the same point at {time_s} s"),
                "two different points",
                "move one of them",
            );
            return None;
        }
        Some(Motion::Aimed { position, target, up })
    }
}
