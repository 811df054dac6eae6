//! Geometry and numerics without any notion of scenes or light. Invariant: the only units are metres, seconds
//! and radians.

mod bounds;
mod brick_rows;
mod chance;
mod chebyshev;
mod close_up;
mod coarse_voxels;
mod cubic;
mod disc;
mod distribution;
mod exponential;
mod flow_noise;
mod interval;
mod kd_density;
mod kronecker;
mod lattice;
mod lit_voxels;
mod placed_points;
mod planar_ray;
mod quadrature;
mod ray;
mod recent;
mod running_product;
mod sampler;
mod vector_voxels;
mod voxel_depths;
mod voxel_means;
mod voxel_walk;
mod voxels;

pub use bounds::{bounds, corners};
pub use brick_rows::BRICK;
pub use chance::Chance;
pub use chebyshev::Antiderivative;
pub use close_up::close_up;
pub use cubic::Cubic;
pub use disc::{disc_from_square, sphere_from_square, square_from_disc, square_from_sphere};
pub use distribution::SquareDistribution;
pub use exponential::fast_exp;
pub use flow_noise::{FLOW_NOISE_DEVIATION, FlowNoise, NoiseWithin};
pub use interval::IntervalSet;
pub use kd_density::KdDensity;
pub use kronecker::{GOLDEN, kronecker};
pub use lit_voxels::LitVoxels;
pub use placed_points::PlacedPoints;
pub use planar_ray::PlanarRay;
pub use quadrature::{gauss_legendre, legendre};
pub use ray::Ray;
pub use recent::Recent;
#[cfg(test)]
pub(crate) use running_product::MULTIPLICATIONS;
pub use running_product::RunningProduct;
pub use sampler::Sampler;
pub use vector_voxels::VectorVoxels;
pub use voxel_depths::VoxelDepths;
pub use voxel_means::VoxelMeans;
pub use voxels::{Voxels, VoxelsBuilder, VoxelsError};
