//! Animated materials, by KHR_animation_pointer. In go a material and its written form, out come channels.
//! Invariant: a number that changes has a channel, or a remark reports its loss.

use super::Writer;
use crate::diagnostic::Loss;
use crate::scene::{Material, MaterialNumbers};
use serde_json::json;
use std::ops::Range;

/// Ranges of [`Material::numbers`].
const BASE_COLOR: Range<usize> = 0..3;
const MIRROR: Range<usize> = 6..9;
const EMISSION: Range<usize> = 9..12;
const OPACITY: usize = 18;
const METALLIC: usize = 19;
const ROUGHNESS: usize = 20;
const NORMAL_SCALE: usize = 22;

/// Form in which a material was written: the property that became glTF's base colour, and the factor of its
/// emission.
pub(super) struct Written {
    pub(super) is_metal: bool,
    pub(super) is_unlit: bool,
    pub(super) emission_strength: f64,
}

impl Writer<'_> {
    /// Adds channels for the numbers of material `index`.
    pub(super) fn carry_changes(&mut self, index: usize, material: &Material, written: &Written) {
        let Some(changes) = &material.changes else { return };
        let times_s = self.moments.of_tracks([changes]);
        let keys: Vec<(f32, MaterialNumbers)> =
            times_s.iter().map(|&time_s| (time_s as f32, changes.at(time_s))).collect();
        let varies = |at: usize| keys.iter().any(|(_, numbers)| numbers[at] != keys[0].1[at]);
        let color = match written {
            Written { is_unlit: true, .. } => EMISSION,
            Written { is_metal: true, .. } => MIRROR,
            _ => BASE_COLOR,
        };
        let mut carried = vec![OPACITY, METALLIC, ROUGHNESS, NORMAL_SCALE];
        carried.extend(color.clone().chain(EMISSION));
        if (0..keys[0].1.len()).any(|at| varies(at) && !carried.contains(&at)) {
            self.lost(Loss::ExportChange, format!(
                "of `{}` only colour, alpha, metal, roughness, emission and normals change, the rest keeps still",
                material.name
            ));
        }
        let times_s: Vec<f32> = keys.iter().map(|(time_s, _)| *time_s).collect();
        let values = |places: &[usize], factor: f64| -> Vec<f32> {
            keys.iter()
                .flat_map(|(_, numbers)| places.iter().map(|&at| (factor * numbers[at]) as f32))
                .collect()
        };
        let mut channel = |path: &str, places: &[usize], factor: f64| {
            if places.iter().any(|&at| varies(at)) {
                self.add_pointer(format!("/materials/{index}/{path}"), &times_s, &values(places, factor));
            }
        };
        let [red, green, blue] = [0, 1, 2].map(|at| color.start + at);
        channel("pbrMetallicRoughness/baseColorFactor", &[red, green, blue, OPACITY], 1.0);
        channel("pbrMetallicRoughness/metallicFactor", &[METALLIC], 1.0);
        channel("pbrMetallicRoughness/roughnessFactor", &[ROUGHNESS], 1.0);
        if !written.is_unlit {
            channel("emissiveFactor", &EMISSION.collect::<Vec<_>>(), written.emission_strength.recip());
        }
        if material.normal_map.is_some() {
            channel("normalTexture/scale", &[NORMAL_SCALE], 1.0);
        }
    }

    /// Adds a channel with linear keys; each time has the same number of values.
    fn add_pointer(&mut self, pointer: String, times_s: &[f32], values: &[f32]) {
        let times: Vec<[f32; 1]> = times_s.iter().map(|&time_s| [time_s]).collect();
        let input = self.binary.floats(&times, None, true);
        let output = match values.len() / times_s.len() {
            1 => self.binary.floats(values.as_chunks::<1>().0, None, false),
            3 => self.binary.floats(values.as_chunks::<3>().0, None, false),
            _ => self.binary.floats(values.as_chunks::<4>().0, None, false),
        };
        self.samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        self.extensions.insert("KHR_animation_pointer");
        let extensions = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        let target = json!({ "path": "pointer", "extensions": extensions });
        self.channels.push(json!({ "sampler": self.samplers.len() - 1, "target": target }));
    }
}
