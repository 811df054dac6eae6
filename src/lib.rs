//! Sunfleck turns a keyframed description of falling leaves into EXR frames whose volumetric
//! shadows are integrated exactly along each ray.
//!
//! # The story in ten lines
//!
//! 1. [`description`] reads what the author wrote: RON, glTF, OBJ. It alone opens input files.
//! 2. [`scene`] resolves it once: SI units, keyframed tracks, no dangling names. A [`scene::Scene`] that exists is valid.
//! 3. [`snapshot`] freezes one shutter interval: everything is placed relative to the camera.
//! 4. [`accel`] answers about its triangles: nearest hit, any hit, and which parts of a ray lie in shadow.
//! 5. [`scattering`] knows what matter does to light: phase functions, optical depth, surfaces.
//! 6. [`transport`] turns a ray into a colour: surface light times transmittance, plus the shafts.
//! 7. [`film`] turns samples into pixels and passes.
//! 8. [`render`] is the one loop that joins transport and film; [`scanline`] draws a frame without rays or shadows, in moments.
//! 9. [`frame_file`] writes a film as EXR, whole or not at all.
//! 10. [`export`] writes a scene as glTF. [`sequence`] decides which frames, [`mod@bench`] measures error against time; [`cli`] is what a user types.
//!
//! Imports point only upward in this list; `tests/architecture.rs` holds that.
//!
//! # One ray, from file to colour
//!
//! ```
//! use sunfleck::description;
//! use sunfleck::math::Sampler;
//! use sunfleck::scene;
//! use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};
//! use sunfleck::transport::{Scratch, Transport, VolumeMethod, radiance};
//!
//! let description = description::load("scenes/first_leaf/scene.ron".as_ref())?;
//! let (scene, settings) = scene::resolve(description, None)?;
//!
//! // Everything as the first camera sees it when the animation begins.
//! let trees = MeshTrees::new(&scene);
//! let shutter = Shutter { open_s: 0.0, close_s: 0.0 };
//! let aspect = settings.size.width as f64 / settings.size.height as f64;
//! let snapshot = Snapshot::new(&scene, &trees, 0, aspect, shutter);
//!
//! // The ray a little above the middle of the picture meets the leaf.
//! let transport =
//!     Transport { volume: VolumeMethod::Segments, mirror_depth: settings.mirror_depth, features: true };
//! let ray = snapshot.view.ray(0.5, 0.41);
//! let mut sampler = Sampler::new(settings.seed, 0, 0, 0);
//! let sample = radiance(&snapshot, &transport, &ray, &mut sampler, &mut Scratch::default());
//!
//! println!("radiance {} W/(m2 sr), of it {} from the fog", sample.radiance, sample.shafts);
//! assert!(sample.shafts.min_element() > 0.0);
//! assert!(sample.radiance.cmpge(sample.shafts).all());
//! assert_eq!(sample.alpha, 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Nothing below [`scene`] can fail: what a file may get wrong is found by [`description::load`] and [`scene::resolve`].
//!
//! # Wording
//!
//! Transforms are named target first: `world_from_leaf` takes a leaf's points to the world. *Mesh*, *node*, *world* and
//! *camera* are the spaces of a file; *relative* has the world's axes and the camera at its origin, and is the only one
//! below [`snapshot`]. Units are metres, seconds and radians unless the name ends in another (`_deg`, `_per_m`).
//! *Radiance* is W/(m² sr) in linear Rec. 709, *irradiance* W/m², *intensity* W/sr. A *medium* is all the fog there is;
//! its `sigma_t` is what it takes from light in a metre, `tau` the optical depth of a stretch, `beta` the light that
//! reaches a point in spite of both. *Shafts* are light scattered in the fog towards the eye. A *pass* is a picture
//! beside the *beauty*; a *channel* is what EXR stores of it. A *sampler* gives low-discrepancy points, nothing else.
//! *Exact* means that visibility is found from the geometry in closed form (docs/decisions/exactness.md).

pub mod accel;
pub mod bench;
pub mod cli;
pub mod color;
pub mod description;
pub mod diagnostic;
pub mod export;
pub mod film;
pub mod fog;
pub mod frame_file;
pub mod light;
pub mod math;
pub mod passes;
pub mod render;
pub mod scanline;
pub mod scattering;
pub mod scene;
pub mod sequence;
pub mod snapshot;
pub mod transport;
