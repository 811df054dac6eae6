//! Animated values that glTF cannot animate. In go tracks, out come nodes with the property `sunfleck_ctl`
//! (read by `scene/from_gltf/controls.rs`). Invariant: a constant value has no such node.

use super::Writer;
use crate::color::Rgb;
use crate::scene::{Key, Segment, Track};
use glam::DVec3;
use serde_json::json;

impl Writer<'_> {
    pub(super) fn carry_number(&mut self, target: String, track: &Track<f64>) {
        if !track.is_constant() {
            let track = track.map_linear(|value| DVec3::new(value, 0.0, 0.0));
            self.carry(target, "translation.x", &track);
        }
    }

    pub(super) fn carry_color(&mut self, target: String, track: &Track<Rgb>) {
        if !track.is_constant() {
            self.carry(target, "translation", track);
        }
    }

    /// Writes the keys of a visibility.
    pub(super) fn carry_switch(&mut self, target: String, track: &Track<bool>) {
        let key = |key: &Key<bool>| Key {
            time_s: key.time_s,
            value: f64::from(u8::from(key.value)),
            to_next: Segment::Step,
        };
        if let Some(track) = Track::new(track.keys().iter().map(key).collect(), track.extend()) {
            self.carry_number(target, &track);
        }
    }

    fn carry(&mut self, target: String, channel: &str, track: &Track<DVec3>) {
        let node = self.add_node(&format!("ctl_{target}"), None);
        let value = track.at(self.moments.start_s);
        self.nodes[node].insert(String::from("translation"), json!(value.to_array()));
        self.set_extra(node, "sunfleck_ctl", json!({ "target": target, "channel": channel }));
        let keys = self.moments.of_track(track);
        self.add_channel(node, "translation", keys);
    }
}
