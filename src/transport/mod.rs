//! Light transport along camera rays. In go a [`Snapshot`](crate::snapshot::Snapshot) and a ray, out comes a
//! [`Sample`]. Invariant: nothing here can fail, as a snapshot that exists is valid.
//!
//! Start reading at [`radiance()`], which asks `Path::follow` for a `Leg` and makes a sample of it. Slices
//! (`slices/`) make their samples by the same function, `Path::sample`.

mod branches;
mod connection;
mod direct;
mod emissive;
mod emissive_fog_light;
mod equiangular;
mod fog_emission;
mod indirect;
mod lamp_fog;
mod lamp_spots;
mod lamps_seen;
mod learned;
mod leg;
mod lit_segments;
mod lobes;
mod march;
mod path;
mod paths;
mod radiance;
mod sample;
mod shafts;
mod shared_walks;
mod sky_light;
pub mod slices;
mod specular;
mod stack;
mod sun_beams;
mod sun_shafts;
mod sun_spots;
mod turn;
mod visibility;

pub use branches::Branches;
pub use direct::unshadowed;
pub use learned::{Learned, Noted};
pub use lit_segments::lit_segments;
pub use path::{MarchSteps, Scratch, Transport, VolumeMethod};
pub use radiance::{Component, OneLight, radiance};
pub use sample::{MATTES_OF_A_SAMPLE, Matte, Sample, SurfaceFeatures};
pub use shared_walks::{Roots, shared_light};
