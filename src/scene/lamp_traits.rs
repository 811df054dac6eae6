//! What Blender's lamps have besides their shape. Invariant: a lamp without any has none of it.

use super::{NodeIndex, Scene};

/// Traits of a point, spot or area light with an extent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LampTraits {
    /// Blender's *Soft Falloff*: it is a disc that faces whatever it lights, and no sphere.
    pub soft_falloff: bool,
    /// Whether a sphere's surface shines inward too, as Cycles' does.
    pub shines_inward: bool,
    /// Whether the camera sees it, and what lies behind it through it.
    pub visible_to_camera: bool,
    /// Whether mirrors and other smooth surfaces do.
    pub visible_in_mirrors: bool,
}

impl Scene {
    /// Gives traits to the lamp at a node.
    pub fn set_lamp_traits(&mut self, node: NodeIndex, traits: LampTraits) {
        if traits != LampTraits::default() {
            self.lamp_traits.insert(node, traits);
        }
    }
}
