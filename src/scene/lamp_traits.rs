//! Blender's settings of lamps that change how a lamp emits and who sees it. In go nodes and traits, out come
//! the traits of a node's lamp. Invariant: lamps with default traits are not stored.

use super::{NodeIndex, Scene};

/// Traits of a point, spot or area light with an extent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LampTraits {
    /// Blender's *Soft Falloff*: the lamp is a disc that faces each point it lights, and not a sphere.
    pub soft_falloff: bool,
    /// Whether a sphere also emits inward, as in Cycles.
    pub shines_inward: bool,
    /// Whether the camera sees the lamp, which then hides what lies behind it.
    pub visible_to_camera: bool,
    /// Whether mirrors and other smooth surfaces show it.
    pub visible_in_mirrors: bool,
}

impl Scene {
    /// Sets the traits of the lamp at a node.
    pub fn set_lamp_traits(&mut self, node: NodeIndex, traits: LampTraits) {
        if traits != LampTraits::default() {
            self.lamp_traits.insert(node, traits);
        }
    }
}
