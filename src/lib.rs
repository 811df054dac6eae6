//! Sunfleck turns a keyframed description of falling leaves into EXR frames. Their volumetric shadows are
//! integrated exactly along each ray.
//!
//! # A frame
//!
//! A [`Scene`] is loaded or built, a [`Renderer`] says what is wanted of it, a [`Frame`] holds
//! arrays with names, shapes and units. All three are whole. What a file asks for and is not
//! honoured is in [`Scene::warnings`]. What cannot be rendered is an error with a remedy. A pass
//! that was asked for has its values.
//!
//! ```
//! use sunfleck::{Pass, Renderer, Scene};
//!
//! let scene = Scene::load("scenes/first_leaf/scene.ron")?;
//! scene.warnings().for_each(|warning| eprintln!("{warning}"));
//!
//! let frame = Renderer::new(&scene)
//!     .frame(24)
//!     .size(48, 27)
//!     .passes([Pass::Depth, Pass::Normal])
//!     .samples(2)
//!     .render()?;
//!
//! let depth = frame.pass(Pass::Depth).expect("it was asked for");
//! assert_eq!((depth.width, depth.height, depth.unit), (48, 27, "m"));
//! // The leaf hangs 3.2 m away.
//! let leaf = depth.at(24, 8).expect("a pixel of the picture");
//! assert!((3.0..3.5).contains(&leaf[0]), "{leaf:?}");
//!
//! let folder = tempfile::tempdir()?;
//! frame.write(folder.path().join("leaf.exr"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Scene::builder`] makes a scene in code. `examples/` has one, a walk through a glTF file's time,
//! and a turntable. Rendering takes the threads of the rayon pool that it is called on; no picture
//! depends on their number.
//!
//! # The story in ten lines
//!
//! Of the modules within; docs/builders/architecture.md follows one picture through them.
//!
//! 1. `description` reads what the author wrote: RON, glTF, OBJ. It alone opens input files.
//! 2. `scene` resolves it once: SI units, keyframed tracks, no dangling names. A scene that exists is valid.
//! 3. `snapshot` freezes one shutter interval: everything is placed relative to the camera.
//! 4. `accel` answers about its triangles: nearest hit, any hit, and which parts of a ray lie in shadow.
//! 5. `scattering` knows what surfaces send on, `light` what reaches a point, `fog` what is lost and
//!    scattered on a way. `indirect` solves light that was scattered before.
//! 6. `transport` turns a ray into a colour: surface light times transmittance, plus the shafts.
//! 7. `film` turns samples into pixels and passes.
//! 8. `render` is the one loop that joins transport and film; `scanline` draws a frame without rays or
//!    shadows, in moments.
//! 9. `frame_file` writes a film as EXR, whole or not at all; `api` is this face, and plans
//!    what a frame needs.
//! 10. `export` writes a scene as glTF. `sequence` decides which frames, `bench` measures error against time;
//!     `cli` is what a user types.
//!
//! Imports point only upward in this list; `tests/architecture.rs` holds that.
//!
//! # Wording
//!
//! Transforms are named target first: `world_from_leaf` takes a leaf's points to the world. *Mesh*, *node*,
//! *world* and *camera* are the spaces of a file. *Relative* space has the world's axes and the camera at its
//! origin; below `snapshot` it is the only one. Units are metres, seconds and radians unless the name ends in
//! another (`_deg`, `_per_m`). *Radiance* is W/(m² sr) in linear Rec. 709, *irradiance* W/m², *intensity*
//! W/sr. A *medium* is all the fog there is. Its `sigma_t` is what it takes from light in a metre, `tau` the
//! optical depth of a stretch. `beta` is the light that reaches a point in spite of both. *Shafts* are light
//! scattered in the fog towards the eye. A *pass* is a picture beside the *beauty*; a *channel* is what EXR
//! stores of it. A *sampler* gives low-discrepancy points, nothing else. *Exact* means that visibility is
//! found from the geometry in closed form (docs/decisions/exactness.md).

// What tests alone look at is no face, and stands where it belongs.
#![cfg_attr(not(feature = "internals"), allow(dead_code, unreachable_pub, unused_imports))]

mod api;
#[cfg(test)]
#[path = "../tests/checkout/mod.rs"]
mod checkout;
#[doc(hidden)]
pub mod cli;

// Tests and benches look inside; nobody else does.
#[cfg(not(feature = "internals"))]
mod accel;
#[cfg(not(feature = "internals"))]
mod bench;
#[cfg(not(feature = "internals"))]
mod canopy;
#[cfg(not(feature = "internals"))]
mod color;
#[cfg(not(feature = "internals"))]
mod description;
#[cfg(not(feature = "internals"))]
mod diagnostic;
#[cfg(not(feature = "internals"))]
mod export;
#[cfg(not(feature = "internals"))]
mod film;
#[cfg(not(feature = "internals"))]
mod fog;
#[cfg(not(feature = "internals"))]
mod frame_file;
#[cfg(not(feature = "internals"))]
mod indirect;
#[cfg(not(feature = "internals"))]
mod light;
#[cfg(not(feature = "internals"))]
mod math;
#[cfg(not(feature = "internals"))]
mod ordinates;
#[cfg(not(feature = "internals"))]
mod passes;
#[cfg(not(feature = "internals"))]
mod render;
#[cfg(not(feature = "internals"))]
mod scanline;
#[cfg(not(feature = "internals"))]
mod scattering;
#[cfg(not(feature = "internals"))]
mod scene;
#[cfg(not(feature = "internals"))]
mod sequence;
#[cfg(not(feature = "internals"))]
mod snapshot;
#[cfg(not(feature = "internals"))]
mod transport;

#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod accel;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod bench;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod canopy;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod color;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod description;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod diagnostic;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod export;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod film;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod fog;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod frame_file;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod indirect;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod light;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod math;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod ordinates;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod passes;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod render;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod scanline;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod scattering;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod scene;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod sequence;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod snapshot;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod transport;

pub use api::{Array, Frame, NodePlace, RenderError, Renderer, Scene, SceneBuilder, SceneOptions, Setting};
pub use description::LoadError;
pub use description::obj::Triangles;
pub use description::ron::{
    Animated, Aperture, Camera, Emitter, Extend, Fall, FallGround, FallMotion, Fog, Julia, Key, Leaves,
    Light, Material, Mist, MistShape, NormalMap, Object, Replacement, Shape, Sky, SkyLight, Species, Sun,
    Wind,
};
pub use diagnostic::{Diagnostic, Diagnostics, Loss, Place, Severity};
pub use frame_file::FrameFileError;
pub use passes::Pass;
pub use render::{Method, Progress, Statistics};
pub use scene::{Bounces, FrameRate, LightUnits, PixelFilter, Size, Window};
pub use transport::MarchSteps;

/// Numbers as the parts of scenes hold them: each type names its range. They are made of plain ones by
/// `into()`, and checked when the scene is built.
pub mod numbers {
    pub use crate::description::ron::{
        AirSpeed, AirVelocity, Anisotropy, ArealMass, Degrees, Direction, DiscAngle, FStop, FieldOfView,
        Finite, FocusDistance, GustScale, HalfAngle, Handle, JuliaPart, Keyable, Keys, LeafLength, Named,
        NonNegative, Number, Point, Positive, Quaternion, QuaternionRate, Range, Span, SpeedGain, Three,
        ToNext, Triple, UnitInterval, Vector, Whole,
    };
}
