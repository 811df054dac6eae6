//! Public interface of the library: a scene, a renderer, a frame. In go a file or parts that a program made,
//! out come arrays and files. Invariant: everything that passes need is prepared here. A scene that cannot be
//! rendered is an error.

mod arrays;
mod builder;
mod changed;
mod error;
mod frame;
mod options;
mod plan;
mod renderer;
mod scene;
mod sequence;
mod viewer;

pub use arrays::Array;
pub use builder::SceneBuilder;
pub use error::{RenderError, Setting};
pub use frame::Frame;
pub use options::SceneOptions;
pub use plan::Plan;
pub use renderer::Renderer;
pub use scene::{NodePlace, Scene};
pub use sequence::Sequence;
pub use viewer::{NAME as VIEWER, Viewer};
