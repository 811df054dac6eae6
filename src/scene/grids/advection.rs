//! Advection between two files of a sequence. In go both, out come voxels carried by their velocities.
//! Invariant: at a file's own time they are that file's.
//!
//! The method is semi-Lagrangian from both sides (Stam 1999, "Stable fluids", section 3.2): values at the
//! places to which velocity leads back, or on, weighted by the nearness of each file.

use super::velocities::Velocities;
use super::{FogPart, FogVoxels};
use crate::math::{BRICK, Voxels, VoxelsBuilder};
use glam::{DAffine3, DVec3, IVec3};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Maximum displacement between two files, in voxels; beyond it nothing is advected.
pub(super) const FARTHEST: f64 = 64.0;
/// Samples of the displacement along an edge of a brick, and margin in voxels.
const PLACES: i32 = 3;
const MARGIN: f64 = 2.0;

/// Advected voxels; `None` if a file has no velocities, or absurd ones.
pub(super) fn between(
    files: [&FogVoxels; 2],
    [earlier_s, later_s]: [f64; 2],
    time_s: f64,
) -> Option<FogVoxels> {
    let weight = (time_s - earlier_s) / (later_s - earlier_s);
    let carry = |file: &FogVoxels, shape_from_voxel: DAffine3, seconds: f64, weight: f64| {
        Some(Carry {
            voxel_from_shape: shape_from_voxel.inverse(),
            velocities: Arc::clone(file.velocities.as_ref()?),
            seconds,
            weight,
        })
    };
    let carries = |spaces: [DAffine3; 2]| {
        let [earlier, later] = files;
        Some([
            carry(earlier, spaces[0], time_s - earlier_s, 1.0 - weight)?,
            carry(later, spaces[1], time_s - later_s, weight)?,
        ])
    };
    let of_parts = carries(files.map(|file| file.shape_from_voxel))?;
    let space = files[0].shape_from_voxel;
    let mut fog = FogVoxels { shape_from_voxel: space, ..FogVoxels::default() };
    for FogPart { extinction, albedo, .. } in parts_of(files) {
        let alike = |part: &&FogPart| (part.extinction, part.albedo) == (extinction, albedo);
        let voxels = files.map(|file| file.parts.iter().find(alike).map(|part| &part.voxels.voxels));
        let Some(voxels) = mixed(voxels, &of_parts, space)? else { continue };
        fog.parts.push(FogPart { extinction, albedo, voxels: Arc::new(voxels.into()) });
    }
    fog.shape_from_emission = files[0].shape_from_emission;
    let of_shining = carries(files.map(|file| file.shape_from_emission))?;
    let mut colors: Vec<_> = files.iter().flat_map(|file| &file.emission).map(|(color, _)| *color).collect();
    colors.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap_or(std::cmp::Ordering::Equal));
    colors.dedup();
    for color in colors {
        let alike = |(of, _): &&(_, _)| *of == color;
        let voxels = files.map(|file| file.emission.iter().find(alike).map(|(_, voxels)| &**voxels));
        let Some(voxels) = mixed(voxels, &of_shining, fog.shape_from_emission)? else { continue };
        fog.emission.push((color, Arc::new(voxels)));
    }
    Some(fog)
}

/// Parts of either file, one for each kind.
fn parts_of(files: [&FogVoxels; 2]) -> Vec<FogPart> {
    let mut parts: Vec<FogPart> = Vec::new();
    for part in files.iter().flat_map(|file| &file.parts) {
        if !parts.iter().any(|other| (other.extinction, other.albedo) == (part.extinction, part.albedo)) {
            parts.push(part.clone());
        }
    }
    parts
}

/// Advection of a file's voxels to a time.
struct Carry {
    voxel_from_shape: DAffine3,
    velocities: Arc<Velocities>,
    /// Time from the file, negative for the later one.
    seconds: f64,
    /// Weight of the file.
    weight: f64,
}

impl Carry {
    /// Displacement of a place of the shape.
    fn way(&self, place: DVec3) -> DVec3 {
        self.seconds * self.velocities.at(place)
    }

    fn at(&self, voxels: &Voxels, place: DVec3) -> f64 {
        self.weight * voxels.at(self.voxel_from_shape.transform_point3(place - self.way(place)))
    }
}

/// Weighted mean of both, on the voxels of a space: the inner `None` if it is empty, the outer one if a
/// displacement is too large.
fn mixed(
    voxels: [Option<&Voxels>; 2],
    carries: &[Carry; 2],
    shape_from_voxel: DAffine3,
) -> Option<Option<Voxels>> {
    let voxel_from_shape = shape_from_voxel.inverse();
    let mut bricks = BTreeSet::new();
    let both = || voxels.into_iter().zip(carries).filter_map(|(voxels, carry)| Some((voxels?, carry)));
    for (voxels, carry) in both() {
        let target_from_voxel = voxel_from_shape * carry.voxel_from_shape.inverse();
        let mut is_near = true;
        voxels.for_each_brick(|first, _| {
            let [mut low, mut high] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            for place in 0..PLACES.pow(3) {
                let along = IVec3::new(place / (PLACES * PLACES), place / PLACES % PLACES, place % PLACES);
                let voxel = first.as_dvec3() - 1.0 + along.as_dvec3() * (9.0 / f64::from(PLACES - 1));
                let way = carry.way(carry.voxel_from_shape.inverse().transform_point3(voxel));
                let way = voxel_from_shape.transform_vector3(way);
                is_near &= way.abs().max_element() <= FARTHEST;
                let target = target_from_voxel.transform_point3(voxel) + way;
                (low, high) = (low.min(target), high.max(target));
            }
            if is_near {
                let [low, high]: [IVec3; 2] =
                    [low - MARGIN, high + MARGIN].map(|corner: DVec3| corner.floor().as_ivec3() >> 3);
                for x in low.x..=high.x {
                    for y in low.y..=high.y {
                        bricks.extend((low.z..=high.z).map(|z| [x, y, z]));
                    }
                }
            }
        });
        if !is_near {
            return None;
        }
    }
    let brick = |brick: [i32; 3]| {
        let first = 8 * IVec3::from(brick);
        let value = |place: usize| {
            let along = IVec3::new(place as i32 >> 6, place as i32 >> 3 & 7, place as i32 & 7);
            let place = shape_from_voxel.transform_point3((first + along).as_dvec3());
            both().map(|(voxels, carry)| carry.at(voxels, place)).sum::<f64>() as f32
        };
        let values: [f32; BRICK] = std::array::from_fn(value);
        values.iter().any(|value| *value > 0.0).then_some((first, values))
    };
    let mut builder = VoxelsBuilder::default();
    let bricks: Vec<[i32; 3]> = bricks.into_iter().collect();
    for (first, values) in bricks.into_par_iter().filter_map(brick).collect::<Vec<_>>() {
        builder.add(first, values);
    }
    Some(builder.built().ok())
}
