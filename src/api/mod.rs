//! The library's face: a scene, a renderer, a frame. In go a file or parts that a program made, out come
//! arrays and files. Invariant: everything else is prepared here, so no picture lacks what its passes need,
//! and what cannot be rendered is an error.

mod animated;
mod arrays;
mod builder;
mod error;
mod falls;
mod frame;
mod lights;
mod options;
mod parts;
mod plan;
mod renderer;
mod scene;
mod surroundings;
mod viewer;

pub use animated::{Animated, Extend, Key};
pub use arrays::Array;
pub use builder::SceneBuilder;
pub use error::{RenderError, Setting};
pub use falls::{Emitter, Fall, FallGround, FallMotion, Species, Wind};
pub use frame::Frame;
pub use lights::{Julia, Light, Sun};
pub use options::SceneOptions;
pub use parts::{Aperture, Camera, LeafMotion, Leaves, Material, NormalMap, Object, Replacement, Shape};
pub(crate) use plan::Plan;
pub use renderer::Renderer;
pub use scene::{NodePlace, Scene};
pub use surroundings::{Fog, Mist, MistShape, Sky, SkyLight};
pub(crate) use viewer::{NAME as VIEWER, Viewer};
