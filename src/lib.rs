//! Sunfleck turns a keyframed description of falling leaves into EXR frames. Their volumetric shadows are
//! integrated exactly along each ray.
//!
//! # A frame
//!
//! A [`Scene`] is loaded or built, a [`Renderer`] has the settings of a picture, and a [`Frame`] holds arrays
//! with names, shapes and units. [`Scene::warnings`] lists a file's requests that are not honoured. A scene
//! that cannot be rendered is an error of one line, with a method for the remedy. Every requested pass has
//! its values.
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
//! // The leaf, .8 m long, hangs 2.7 m away.
//! let leaf = depth.at(24, 8).expect("a pixel of the picture");
//! assert!((2.3..3.1).contains(&leaf[0]), "{leaf:?}");
//!
//! let folder = tempfile::tempdir()?;
//! frame.write(folder.path().join("leaf.exr"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Renderer::sequence`] renders frame after frame. [`Scene::builder`] makes a scene in code, of parts that
//! start with defaults; each is changed by its `with`, as by [`Camera::with`]. `examples/` has such a scene,
//! a walk through a glTF file's time, and a turntable. Rendering uses the current rayon pool; no picture
//! depends on the number of threads.
//!
//! # The story in ten lines
//!
//! docs/builders/architecture.md follows one picture through these modules.
//!
//! 1. `description` reads what the author wrote: RON, glTF, OBJ. It alone opens input files.
//! 2. `scene` resolves it once: SI units, keyframed tracks, no dangling names. A scene that exists is valid.
//! 3. `snapshot` freezes one shutter interval: everything is placed relative to the camera.
//! 4. `accel` has trees of its triangles: nearest hit, any hit, and the parts of a ray in shadow.
//! 5. `scattering` has the BSDFs of surfaces, `light` the direct light at a point, `fog` transmittance and
//!    in-scattering along a ray. `indirect` has light of more than one scattering: `ordinates` solves it,
//!    with cross-sections and sources from `canopy`.
//! 6. `transport` turns a ray into a colour: surface light times transmittance, plus the shafts.
//! 7. `film` turns samples into pixels and passes.
//! 8. `render` is the one loop that joins transport and film; `scanline` draws a fast preview without rays
//!    or shadows.
//! 9. `frame_file` writes a film as EXR, whole or not at all; `api` is this interface, and prepares
//!    what a frame needs.
//! 10. `export` writes a scene as glTF. `sequence` selects frames, `bench` measures error against time;
//!     `cli` is the program's command line.
//!
//! Imports have one direction, in the order that `tests/architecture.rs` lists and checks.
//!
//! # Wording
//!
//! Transforms are named target first: `world_from_leaf` takes a leaf's points to the world. *Mesh*, *node*,
//! *world* and *camera* are the spaces of a file. *Relative* space has the world's axes and the camera at its
//! origin; below `snapshot` it is the only one. Units are metres, seconds and radians unless the name ends in
//! another (`_deg`, `_per_m`). *Radiance* is W/(m² sr) in linear Rec. 709, *irradiance* W/m², *intensity*
//! W/sr. A *medium* is all fog together; `sigma_t` is its extinction per metre, `tau` the optical depth
//! along a ray. *Shafts* are light that fog scatters into the camera ray. A *pass* is a picture beside the
//! *beauty*; a *channel* is what EXR stores of it. A *sampler* gives low-discrepancy points, nothing else.
//! *Exact* means visibility in closed form, from the geometry (docs/decisions/exactness.md).

// Items that only tests of the library use stay where they belong, unreachable without the program.
#![cfg_attr(not(feature = "program"), allow(dead_code, unreachable_pub, unused_imports))]
// Public items of the program's feature link to private ones.
#![cfg_attr(feature = "program", allow(rustdoc::private_intra_doc_links))]

#[cfg(test)]
#[path = "../tests/checkout/mod.rs"]
mod checkout;

#[path = ""]
mod inside {
    pub mod accel;
    pub mod api;
    #[cfg(feature = "program")]
    pub mod bench;
    pub mod canopy;
    pub mod color;
    pub mod description;
    pub mod diagnostic;
    pub mod export;
    pub mod film;
    pub mod fog;
    pub mod frame_file;
    pub mod indirect;
    pub mod light;
    pub mod math;
    pub mod ordinates;
    pub mod passes;
    pub mod render;
    pub mod scanline;
    pub mod scattering;
    pub mod scene;
    pub mod sequence;
    pub mod snapshot;
    pub mod transport;
}

// Open to the program and its tests alone.
#[cfg(not(feature = "program"))]
use inside::*;
#[cfg(feature = "program")]
#[doc(hidden)]
pub use inside::*;

pub use inside::api::{
    Array, Frame, NodePlace, RenderError, Renderer, Scene, SceneBuilder, SceneOptions, Sequence, Setting,
};
pub use inside::description::LoadError;
pub use inside::description::obj::Triangles;
pub use inside::description::ron::{
    Animated, Aperture, Camera, Emitter, Extend, Fall, FallGround, FallMotion, Fog, Julia, Key, Leaves,
    Light, Material, Mist, MistShape, NormalMap, Object, Replacement, Shape, Sky, SkyLight, Species, Sun,
    Wind,
};
pub use inside::diagnostic::{Diagnostic, Diagnostics, Loss, Place, Severity};
pub use inside::frame_file::FrameFileError;
pub use inside::passes::Pass;
pub use inside::render::{Method, Progress, Statistics};
pub use inside::scene::{Bounces, FrameRate, LightUnits, PixelFilter, Size, Window};
pub use inside::transport::MarchSteps;

/// Numbers of scene parts; each type has its range. Plain numbers convert by `into()`, and are checked when
/// the scene is built.
pub mod numbers {
    pub use crate::inside::description::ron::{
        AirSpeed, AirVelocity, Anisotropy, ArealMass, Degrees, Direction, DiscAngle, FStop, FieldOfView,
        Finite, FocusDistance, GustScale, HalfAngle, Handle, JuliaPart, Keyable, Keys, LeafLength, Named,
        NonNegative, Number, Point, Positive, Quaternion, QuaternionRate, Range, Span, SpeedGain, Three,
        ToNext, Triple, UnitInterval, Vector, Whole,
    };
}
