//! A ray becomes a colour. In goes a [`Snapshot`](crate::snapshot::Snapshot) and a ray, out comes
//! a [`Sample`]. Start reading at [`radiance`]. Invariant: nothing here can fail; a snapshot that
//! exists is valid.

mod direct;
mod equiangular;
mod lit_segments;
mod march;
mod near_light;
mod radiance;
mod running_product;
mod sample;
mod shafts;
mod sky_light;
pub mod slices;
mod stack;
mod sun_stretch;
mod veils;
mod visibility;

pub use direct::unshadowed;
pub use lit_segments::LitSegments;
pub use march::MarchSteps;
pub use radiance::{Part, Scratch, Transport, radiance, radiance_of_part};
pub use sample::{MATTES_OF_A_SAMPLE, Matte, Sample, SurfaceFeatures};
pub use shafts::VolumeMethod;
