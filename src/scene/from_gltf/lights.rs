//! Lights in radiometric units. In go lights of a file in any unit, out come lights. Invariant: one W/m^2 or
//! W/sr is 683 lux or candela, the convention of Blender's exporter.

use super::Builder;
use super::light_extras::LightExtras;
use crate::color::LUMENS_PER_WATT;
use crate::description::gltf;
use crate::diagnostic::{Diagnostic, Loss};
use crate::scene::{Light, LightKind, LightUnits, NodeIndex, Track};
use std::f64::consts::PI;

impl Builder<'_> {
    /// Adds a light for every node of the scene with one.
    pub(super) fn add_lights(&mut self, asked: Option<LightUnits>, in_extras: Option<&str>) {
        let units = asked.or_else(|| self.light_units(in_extras)).unwrap_or(LightUnits::Spec);
        let mut any = false;
        for (index, node) in self.source.nodes.iter().enumerate() {
            let Some(number) = self.node_numbers[index] else { continue };
            let extras = self.light_extras(index, node);
            let path = format!("nodes[{index}].extras.sunfleck_light");
            if let Some(extras) = &extras {
                self.set_traits(number, extras);
            }
            if let Some(light) = node.light {
                any = true;
                self.add_light(light, number, units, extras.as_ref(), &path);
            } else if let Some(extras) = extras {
                self.add_area_light(&node.name, number, &extras, &path);
            }
        }
        if any && asked.is_none() && in_extras.is_none() {
            self.scene.guessed_light_units = Some(units);
            self.report.push(
                Diagnostic::note(
                    self.report.at("extensions.KHR_lights_punctual"),
                    "the file does not say its light units, lux and candela are assumed",
                )
                .remedy("give --light-units, or the scene's custom property `sunfleck` a field light_units"),
            );
        }
    }

    fn light_units(&mut self, in_extras: Option<&str>) -> Option<LightUnits> {
        Some(match in_extras? {
            "spec" => LightUnits::Spec,
            "compat" => LightUnits::Compat,
            "raw" => LightUnits::Raw,
            other => {
                let path = format!("scenes[{}].extras.sunfleck.light_units", self.source.scene);
                self.report.error(path, format!("`{other}` are no light units"), "spec, compat or raw");
                return None;
            }
        })
    }

    fn add_light(
        &mut self,
        index: usize,
        node: NodeIndex,
        units: LightUnits,
        extras: Option<&LightExtras>,
        path: &str,
    ) {
        let light = &self.source.lights[index];
        if light.range_m.is_some() {
            self.report.not_honoured(Loss::LightRange, &light.name);
        }
        let power = self.light_power(index, units, watts_per_unit(units, light.kind));
        if power.keys().iter().any(|key| !key.value.is_finite()) {
            let path = String::from("extensions.KHR_lights_punctual.lights");
            self.report.error(path, format!("`{}` is infinitely bright", light.name), "a finite intensity");
        }
        let kind = match light.kind {
            gltf::LightKind::Directional => LightKind::Sun,
            gltf::LightKind::Point => LightKind::Point,
            gltf::LightKind::Spot { inner_angle, outer_angle } => {
                let (outer_angle, blend) = self.spot_angles(index, inner_angle, outer_angle);
                LightKind::Spot { outer_angle, blend, radius: Track::from(0.0) }
            }
        };
        let kind = match extras {
            Some(extras) => self.extend(kind, extras, path),
            None => kind,
        };
        let name = self.scene.nodes[node].name.clone();
        self.scene.lights.push(Light { name, node, power, kind });
    }
}

/// Factor from one unit of a light's intensity to W/m^2 (sun) or W/sr (point, spot). Blender's exporter
/// writes, for a sun of S W/m^2 and a lamp of P W: spec 683 S and 683 P / 4 pi, compat S and P / 4 pi, raw
/// S and P.
fn watts_per_unit(units: LightUnits, kind: gltf::LightKind) -> f64 {
    match (units, kind) {
        (LightUnits::Spec, _) => LUMENS_PER_WATT.recip(),
        (LightUnits::Compat, _) | (LightUnits::Raw, gltf::LightKind::Directional) => 1.0,
        (LightUnits::Raw, _) => (4.0 * PI).recip(),
    }
}
