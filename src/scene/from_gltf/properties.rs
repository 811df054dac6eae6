//! Animated values. In go channels, out come tracks. Invariant: known wrong units of Blender's exporter are
//! corrected.

use super::Builder;
use super::joined::{Course, joined};
use super::nodes::track;
use crate::color::{LUMENS_PER_WATT, Rgb};
use crate::description::gltf::{self, Channel, Interpolation, Property};
use crate::diagnostic::Loss;
use crate::scene::{Animate, LightUnits, MaterialNumbers, Track};
use std::f64::consts::PI;

/// Tolerance of an exposure that is rounded to two digits, as Blender's settings have them.
const EXPOSURE_TOLERANCE: f64 = 1e-5;
/// Maximum magnitude of Blender's exposures.
const LARGEST_EXPOSURE: f64 = 10.0;
/// Softness of a spot's edge below which it is hard, up to rounding to single precision.
const SOFTEST_HARD_EDGE: f64 = 1e-6;

impl<'a> Builder<'a> {
    /// Collects the channel of every animated property; the last one counts.
    pub(super) fn collect_channels(&mut self) {
        for channel in &self.source.channels {
            let Channel { property, index, place, .. } = channel;
            if self.channels.insert((*property, *index), channel).is_none() {
                continue;
            }
            match property.is_of_transform() {
                true => self.report.not_honoured(Loss::AnimationsConflict, &self.source.nodes[*index].name),
                false => self.report.not_honoured(Loss::AnimatedValuesConflict, place),
            }
        }
    }

    pub(super) fn property(&self, property: Property, index: usize) -> Option<&'a Channel> {
        self.channels.get(&(property, index)).copied()
    }

    /// Track of a channel under a linear map of each value or derivative.
    fn mapped<T: Animate>(&self, channel: &Channel, map: impl Fn(&[f64]) -> T) -> Option<Track<T>> {
        let width = channel.width();
        let values: Vec<T> = channel.values.chunks_exact(width).map(map).collect();
        track(&channel.times_s, channel.interpolation, &values, &self.clock)
    }

    /// Track of a property under a linear map of each value or derivative; `still` without animation.
    pub(super) fn keyed<T: Animate>(
        &self,
        property: Property,
        index: usize,
        still: T,
        map: impl Fn(&[f64]) -> T,
    ) -> Track<T> {
        let channel = self.property(property, index);
        channel.and_then(|channel| self.mapped(channel, map)).unwrap_or(Track::from(still))
    }

    /// Track of a number, as [`Self::keyed`].
    pub(super) fn keyed_number(&self, property: Property, index: usize, still: f64) -> Track<f64> {
        self.keyed(property, index, still, |value| value[0])
    }

    /// Visibility of a node.
    pub(super) fn visible(&self, index: usize) -> Track<bool> {
        let still = Track::from(self.source.nodes[index].visible);
        let Some(channel) = self.property(Property::NodeVisible, index) else { return still };
        let values: Vec<bool> = channel.values.iter().map(|value| *value != 0.0).collect();
        track(&channel.times_s, Interpolation::Step, &values, &self.clock).unwrap_or(still)
    }

    /// Colour times intensity of a light, in watts by the factor `watts`.
    pub(super) fn light_power(&mut self, index: usize, units: LightUnits, watts: f64) -> Track<Rgb> {
        let light = &self.source.lights[index];
        let (color, intensity) = (light.color, light.intensity);
        let of_color = self.property(Property::LightColor, index);
        let of_intensity = self.property(Property::LightIntensity, index);
        let factor = of_intensity.map_or(1.0, |channel| self.intensity_factor(light, channel, units));
        let scale = factor * watts;
        let power = match (of_color, of_intensity) {
            (None, None) => None,
            (None, Some(channel)) => self.mapped(channel, |value| color * (value[0] * scale)),
            (Some(channel), None) => {
                self.mapped(channel, |value| Rgb::from_slice(value) * (intensity * watts))
            }
            (Some(colors), Some(intensities)) => {
                let colors = self.mapped(colors, Rgb::from_slice);
                let intensities = self.mapped(intensities, |value| value[0] * scale);
                colors.zip(intensities).and_then(|(colors, numbers)| {
                    let courses = [Course::of(&colors), Course::of(&numbers)];
                    joined(&courses, |time_s| colors.at(time_s) * numbers.at(time_s))
                })
            }
        };
        power.unwrap_or(Track::from(color * (intensity * watts)))
    }

    /// Factor from animated intensities to the unit of the constant one.
    ///
    /// Blender 5.0's exporter converts animated intensities differently from constant ones (io_scene_gltf2,
    /// `keyframes.py` and `lights.py`). It forgets the division by 4 pi for lamps, the factor of 683 for
    /// suns, and the exposure for all. The exposure follows from the constant intensity, which is that of
    /// frame 0.
    fn intensity_factor(&mut self, light: &gltf::Light, channel: &Channel, units: LightUnits) -> f64 {
        if !self.source.generator.contains("Blender") {
            return 1.0;
        }
        let forgotten = match (units, light.kind) {
            (LightUnits::Raw, _) | (LightUnits::Compat, gltf::LightKind::Directional) => 1.0,
            (LightUnits::Spec, gltf::LightKind::Directional) => LUMENS_PER_WATT,
            (LightUnits::Spec | LightUnits::Compat, _) => (4.0 * PI).recip(),
        };
        let at_frame_0 = self.mapped(channel, |value| value[0]).map_or(0.0, |track| track.at(0.0));
        let exposure = |forgotten: f64| {
            let exposure = (light.intensity / (at_frame_0 * forgotten)).log2();
            let rounded = (exposure * 100.0).round() / 100.0;
            ((exposure - rounded).abs() < EXPOSURE_TOLERANCE && rounded.abs() <= LARGEST_EXPOSURE)
                .then_some(rounded)
        };
        let found = [forgotten, 1.0].into_iter().find_map(|factor| Some(factor * exposure(factor)?.exp2()));
        if found.is_none() {
            self.report.not_honoured(Loss::LightExposure, &light.name);
        }
        let factor = found.unwrap_or(forgotten);
        if factor != 1.0 {
            self.report.not_honoured(Loss::LightIntensityUnits, &light.name);
        }
        factor
    }

    /// Track of the parameters that `converted` returns for a material; `None` if it is constant.
    pub(super) fn material_changes(
        &self,
        index: usize,
        converted: impl Fn(&gltf::Material) -> MaterialNumbers,
    ) -> Option<Track<MaterialNumbers>> {
        let four = |value: &[f64]| std::array::from_fn(|index| value.get(index).copied().unwrap_or_default());
        let channels = Property::OF_MATERIALS.map(|property| {
            let channel = self.property(property, index)?;
            Some((property, self.mapped(channel, four)?))
        });
        let courses: Vec<Course> = channels.iter().flatten().map(|(_, track)| Course::of(track)).collect();
        let at = |time_s: f64| {
            let mut now = self.source.materials[index].clone();
            for (property, track) in channels.iter().flatten() {
                let value = track.at(time_s);
                let color = Rgb::from_slice(&value);
                match property {
                    Property::BaseColor => now.base_color = value,
                    Property::Metallic => now.metallic = value[0],
                    Property::Roughness => now.roughness = value[0],
                    Property::Emission => now.emission = color,
                    Property::EmissionStrength => now.emission_strength = value[0],
                    _ => now.normal_map = now.normal_map.map(|(map, _)| (map, value[0])),
                }
            }
            converted(&now)
        };
        joined(&courses, at)
    }

    /// Whether any of these properties is animated.
    pub(super) fn is_animated(&self, properties: &[Property], index: usize) -> bool {
        properties.iter().any(|property| self.property(*property, index).is_some())
    }

    /// Half angle of a spot, and the softness of its edge.
    pub(super) fn spot_angles(&self, index: usize, inner: f64, outer: f64) -> (Track<f64>, Track<f64>) {
        let blend = |inner: f64, outer: f64| match (1.0 - inner / outer).clamp(0.0, 1.0) {
            blend if blend < SOFTEST_HARD_EDGE => 0.0,
            blend => blend,
        };
        let outer_track = self.keyed_number(Property::SpotOuterAngle, index, outer);
        let inner_track = self.keyed_number(Property::SpotInnerAngle, index, inner);
        // In Blender the inner angle is a fraction of the outer one, and changes with it.
        let goes_along = self.source.generator.contains("Blender") && inner_track.is_constant();
        let blend_track = match outer_track.is_constant() && inner_track.is_constant() || goes_along {
            true => Track::from(blend(inner, outer)),
            false => {
                let courses = [Course::of(&inner_track), Course::of(&outer_track)];
                let at = |time_s| blend(inner_track.at(time_s), outer_track.at(time_s));
                joined(&courses, at).unwrap_or(Track::from(blend(inner, outer)))
            }
        };
        (outer_track, blend_track)
    }
}
