//! Animated values that glTF cannot animate: nodes with the property `sunfleck_ctl` carry them in their
//! translation or scale. In go these nodes and the scene, out come tracks. Invariant: every key, and every
//! curve between keys, is within its field's range.

use super::Builder;
use super::extras::{self, Channels, Unknown};
use super::light_extras::{NARROWEST_SPREAD, WIDEST_SPREAD};
use crate::color::Rgb;
use crate::description::gltf::Property;
use crate::description::ron::{self, Range as _};
use crate::diagnostic::{Diagnostic, Loss};
use crate::scene::drift::Drift;
use crate::scene::{
    Animate, Fog, FogShape, Key, Lens, LightKind, Motion, NodeIndex, Segment, SunDisc, SunPicture, SunShows,
    Track,
};
use glam::DVec3;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};

/// `sunfleck_ctl` of a node.
#[derive(Debug, Deserialize)]
struct Control {
    /// Owner, property and field, separated by dots. The owner's name may have dots of its own.
    target: String,
    /// `translation` or `scale`, for one number followed by `.x`, `.y` or `.z`.
    channel: String,
    #[serde(flatten)]
    unknown: Unknown,
}

/// Track in a node.
enum Carried {
    Number(Track<f64>),
    Color(Track<Rgb>),
}

struct Range {
    admits: fn(f64) -> bool,
    expected: &'static str,
}

const NOT_NEGATIVE: Range =
    Range { admits: |value| (0.0..1e15).contains(&value), expected: "numbers of at least 0" };
const POSITIVE: Range = Range { admits: |value| value > 0.0 && value < 1e15, expected: "numbers above 0" };
const SHARE: Range = Range { admits: ron::UnitInterval::contains, expected: "numbers from 0 to 1" };
const ANISOTROPY: Range =
    Range { admits: ron::Anisotropy::contains, expected: "numbers from -0.9999 to 0.9999" };
const ANGLE: Range =
    Range { admits: |value| (0.0..PI).contains(&value), expected: "radians, at least 0 and less than pi" };
const FIELD_OF_VIEW: Range = Range {
    admits: |value| ron::FieldOfView::contains(value.to_degrees()),
    expected: "radians that are from 0.0001 to 179.9 degrees",
};
const CONE: Range = Range {
    admits: |value| value > 0.0 && value <= FRAC_PI_2,
    expected: "radians, above 0 and at most pi / 2",
};
const SPREAD: Range = Range {
    admits: |value| (NARROWEST_SPREAD..=WIDEST_SPREAD).contains(&value),
    expected: "radians, from 0.01 to pi",
};
const FRACTAL: Range = Range { admits: ron::JuliaPart::contains, expected: "numbers from -2 to 2" };
const ANY: Range = Range { admits: f64::is_finite, expected: "numbers" };

impl Builder<'_> {
    /// Sets every value that a node carries on its target.
    pub(super) fn apply_controls(&mut self) {
        let mut targets = BTreeSet::new();
        for (index, node) in self.source.nodes.iter().enumerate() {
            let Some(number) = self.node_numbers[index] else { continue };
            let path = format!("nodes[{index}]");
            let control = extras::read(&node.extras, "sunfleck_ctl", &path, &mut self.report);
            let Some(Control { target, channel, unknown }) = control else { continue };
            let path = format!("{path}.extras.sunfleck_ctl");
            extras::tell_unknown(&unknown, &mut self.report, |field| format!("{path}.{field}"));
            let Some(carried) = self.carried(number, &channel) else {
                let found = format!("`{channel}` is no channel");
                let expected = "translation or scale, or one number of it such as translation.x";
                self.report.error(format!("{path}.channel"), found, expected);
                continue;
            };
            if !targets.insert(target.clone()) || self.has_pointer(&target) {
                let found =
                    format!("something else animates `{target}` too: the last `sunfleck_ctl` is taken");
                self.report.push(Diagnostic::note(self.report.at(path.as_str()), found));
            }
            if self.control(&target, &carried, &path).is_none() {
                self.report.not_honoured(Loss::CarriedValueWithoutTarget, &target);
            }
        }
    }

    /// Whether a pointer animates the value of `target`.
    fn has_pointer(&self, target: &str) -> bool {
        let Some((owner, field)) = target.rsplit_once('.') else { return false };
        let Some((owner, _)) = owner.rsplit_once('.') else { return false };
        let nodes = &self.source.nodes;
        let Some(node) = nodes.iter().position(|node| node.name == owner) else { return false };
        let (properties, index): (&[Property], _) = match field {
            "strength_w_m2" | "power_w" => {
                (&[Property::LightColor, Property::LightIntensity], nodes[node].light)
            }
            "outer_angle" => (&[Property::SpotOuterAngle], nodes[node].light),
            "blend" => (&[Property::SpotInnerAngle], nodes[node].light),
            "yfov" => (&[Property::CameraFovY], nodes[node].camera),
            "height" => (&[Property::CameraHalfHeight], nodes[node].camera),
            "visible" => (&[Property::NodeVisible], Some(node)),
            _ => return false,
        };
        index.is_some_and(|index| self.is_animated(properties, index))
    }

    fn carried(&self, node: NodeIndex, channel: &str) -> Option<Carried> {
        let (vector, axis) = match channel.split_once('.') {
            Some((vector, axis)) => (vector, Some(["x", "y", "z"].iter().position(|name| *name == axis)?)),
            None => (channel, None),
        };
        let motion = &self.scene.nodes[node].motion;
        let track = match (vector, motion) {
            ("translation", Motion::Keyed { translation, .. }) => translation.clone(),
            ("scale", Motion::Keyed { scale, .. }) => scale.clone(),
            ("translation", still) => Track::from(still.parent_from_node(0.0).translation),
            ("scale", still) => Track::from(still.parent_from_node(0.0).to_scale_rotation_translation().0),
            _ => return None,
        };
        Some(match axis {
            Some(axis) => Carried::Number(track.map_linear(|value: DVec3| value[axis])),
            None => Carried::Color(track),
        })
    }

    /// Sets a track on its target; `None` if the target does not exist.
    fn control(&mut self, target: &str, carried: &Carried, path: &str) -> Option<()> {
        let (owner, field) = target.rsplit_once('.')?;
        let (owner, property) = owner.rsplit_once('.')?;
        match property {
            // The scene's fog was added last.
            "sunfleck_fog" if owner == "scene" && self.source.extras.get("sunfleck_fog").is_some() => {
                let fog = self.scene.fogs.len().checked_sub(1)?;
                self.control_fog(fog, field, carried, path)
            }
            "sunfleck_fog_volume" => {
                let fog = self.scene.fogs.iter().position(|fog| fog.name == owner)?;
                self.control_fog(fog, field, carried, path)
            }
            "sunfleck_light" => {
                let light = self.scene.lights.iter().position(|light| light.name == owner)?;
                self.control_light(light, field, carried, path)
            }
            "sunfleck_camera" => {
                let camera = self.scene.cameras.iter().position(|camera| camera.name == owner)?;
                self.control_camera(camera, field, carried, path)
            }
            "sunfleck_node" if field == "visible" => {
                let node = self.scene.nodes.iter().position(|node| node.name == owner)?;
                let number = self.number(carried, &ANY, path)?;
                self.scene.nodes[node].visible = switching(&number);
                Some(())
            }
            _ => None,
        }
    }

    fn control_fog(&mut self, fog: usize, field: &str, carried: &Carried, path: &str) -> Option<()> {
        let is = |fog: &Fog| matches!(fog.shape, FogShape::EvenBox | FogShape::Voxels(_));
        match field {
            "density" => self.scene.fogs[fog].density_per_m = self.color(carried, &NOT_NEGATIVE, path)?,
            "albedo" => self.scene.fogs[fog].albedo = self.color(carried, &SHARE, path)?,
            "anisotropy" => self.scene.fogs[fog].anisotropy = self.number(carried, &ANISOTROPY, path)?,
            "emission" => {
                let color = self.color(carried, &NOT_NEGATIVE, path)?;
                let FogShape::Voxels(grids) = &mut self.scene.fogs[fog].shape else { return None };
                grids.emission = color;
            }
            "scale_height" if !is(&self.scene.fogs[fog]) => {
                let number = self.number(carried, &POSITIVE, path)?;
                match &mut self.scene.fogs[fog].shape {
                    FogShape::ThinningBox(falloff) | FogShape::Layer(falloff) => {
                        falloff.scale_height_m = number;
                    }
                    FogShape::Mist(mist) => mist.scale_height_m = Some(number),
                    FogShape::EvenBox | FogShape::Voxels(_) => {}
                }
            }
            _ => return self.control_mist(fog, field, carried, path),
        }
        Some(())
    }

    fn control_mist(&mut self, fog: usize, field: &str, carried: &Carried, path: &str) -> Option<()> {
        let range = if field == "mist_cover" { &SHARE } else { &ANY };
        let number = self.number(carried, range, path);
        let FogShape::Mist(mist) = &mut self.scene.fogs[fog].shape else { return None };
        match (field, carried) {
            ("mist_cover", _) => mist.cover = number?,
            ("mist_evolution_turns", _) => mist.evolution_turns = number?,
            ("mist_wind", Carried::Color(wind)) => mist.wind = Drift::new(wind.clone()),
            _ => return None,
        }
        Some(())
    }

    fn control_light(&mut self, light: usize, field: &str, carried: &Carried, path: &str) -> Option<()> {
        let (power, unit) = self.scene.lights[light].kind.blenders_power();
        if field == power {
            let color = self.light_color(light);
            let power = match carried {
                Carried::Number(number) => number.map_linear(|value| value * color),
                Carried::Color(color) => color.clone(),
            };
            self.check(&power, Rgb::to_array, &NOT_NEGATIVE, path);
            self.scene.lights[light].power = power.map_linear(|value| value * unit.recip());
            return Some(());
        }
        let number = self.number(carried, range_of_light(field), path)?;
        match (&mut self.scene.lights[light].kind, field) {
            (kind @ LightKind::Sun, "angle") => *kind = LightKind::SunDisc(SunDisc::even(number)),
            (LightKind::SunDisc(disc), "angle") => disc.angular_diameter = number,
            (LightKind::SunDisc(disc), "picture_rotation") => disc.picture_rotation = number,
            (LightKind::SunDisc(disc), "fractal_real" | "fractal_imaginary") => {
                disc.picture = Some(changed_fractal(disc.picture.as_ref()?, field, number)?);
            }
            (kind @ (LightKind::Point | LightKind::Sphere { .. }), "radius") => {
                *kind = LightKind::Sphere { radius: number };
            }
            (LightKind::Spot { radius, .. }, "radius") => *radius = number,
            (LightKind::Spot { outer_angle, .. }, "outer_angle") => *outer_angle = number,
            (LightKind::Spot { blend, .. }, "blend") => *blend = number,
            (LightKind::Area { width, .. }, "width") => *width = number,
            (LightKind::Area { height, .. }, "height") => *height = number,
            (LightKind::Area { spread, .. }, "spread") => *spread = number,
            _ => return None,
        }
        Some(())
    }

    /// Colour of a light, which a scalar power multiplies.
    fn light_color(&self, light: usize) -> Rgb {
        let node = self.node_numbers.iter().position(|number| *number == Some(self.scene.lights[light].node));
        let Some(node) = node.map(|node| &self.source.nodes[node]) else { return Rgb::ONE };
        match node.light {
            Some(light) => self.source.lights[light].color,
            None => {
                let color = node.extras.get("sunfleck_light").and_then(|extras| extras.get("color"));
                color.and_then(|color| Channels::deserialize(color).ok()).map_or(Rgb::ONE, Rgb::from)
            }
        }
    }

    fn control_camera(&mut self, camera: usize, field: &str, carried: &Carried, path: &str) -> Option<()> {
        let range = if field == "yfov" { &FIELD_OF_VIEW } else { &POSITIVE };
        let number = self.number(carried, range, path)?;
        let camera = &mut self.scene.cameras[camera];
        match (field, &mut camera.lens, &mut camera.aperture) {
            ("yfov", Lens::Perspective { fov_y }, _) => *fov_y = number,
            ("height", Lens::Orthographic { height_m }, _) => *height_m = number,
            ("fstop", _, Some(aperture)) => aperture.f_stop = number,
            ("focus_distance", _, Some(aperture)) => aperture.focus_distance_m = number,
            _ => return None,
        }
        Some(())
    }

    fn number(&mut self, carried: &Carried, range: &Range, path: &str) -> Option<Track<f64>> {
        let Carried::Number(number) = carried else { return None };
        self.check(number, |value| [*value], range, path);
        Some(number.clone())
    }

    fn color(&mut self, carried: &Carried, range: &Range, path: &str) -> Option<Track<Rgb>> {
        let color = match carried {
            Carried::Number(number) => number.map_linear(Rgb::splat),
            Carried::Color(color) => color.clone(),
        };
        self.check(&color, Rgb::to_array, range, path);
        Some(color)
    }

    /// Reports the first key whose value, or whose curve to the next, is out of range.
    fn check<T: Animate, const WIDTH: usize>(
        &mut self,
        track: &Track<T>,
        numbers: impl Fn(&T) -> [f64; WIDTH],
        range: &Range,
        path: &str,
    ) {
        let wrong = |value: &T| numbers(value).into_iter().find(|number| !(range.admits)(*number));
        let keys = track.keys();
        let found = keys.iter().enumerate().find_map(|(index, key)| {
            let next = keys.get(index + 1);
            let inner = next.map(|next| key.inner_control_points(next)).unwrap_or_default();
            let value = std::iter::once(key.value).chain(inner).find_map(|value| wrong(&value))?;
            Some((key.time_s, value))
        });
        if let Some((time_s, value)) = found {
            let found = format!("from {time_s:.4} s on the value is or comes near {value}");
            self.report.error(path, found, range.expected);
        }
    }
}

fn range_of_light(field: &str) -> &'static Range {
    match field {
        "angle" => &ANGLE,
        "radius" => &NOT_NEGATIVE,
        "outer_angle" => &CONE,
        "spread" => &SPREAD,
        "blend" => &SHARE,
        "picture_rotation" => &ANY,
        "fractal_real" | "fractal_imaginary" => &FRACTAL,
        _ => &POSITIVE,
    }
}

/// Picture whose fractal's constant changes; `None` if it has no fractal.
fn changed_fractal(picture: &SunPicture, field: &str, number: Track<f64>) -> Option<SunPicture> {
    let SunShows::Julia(julia) = picture.shows() else { return None };
    let mut julia = julia.clone();
    if field == "fractal_real" {
        julia.real = number
    } else {
        julia.imaginary = number
    }
    SunPicture::new(SunShows::Julia(julia), picture.limb_darkening())
}

/// Visibility where the number is at least a half, in steps from key to key.
fn switching(number: &Track<f64>) -> Track<bool> {
    let key = |key: &Key<f64>| Key { time_s: key.time_s, value: key.value >= 0.5, to_next: Segment::Step };
    let mut keys: Vec<Key<bool>> = number.keys().iter().map(key).collect();
    keys.dedup_by_key(|key| key.value);
    Track::new(keys, number.extend()).unwrap_or(Track::from(true))
}
