//! Transforms of voxels. In go bytes, out comes an affine map. Invariant: every number is finite. Source:
//! `read` of the maps in `openvdb/math/Maps.h`.

use super::bytes::{Bytes, Fault, Read};
use glam::{DAffine3, DMat3, DVec3};

/// Reads the transform from voxel coordinates, which are integers at centres, to the grid's own space.
pub(super) fn read(bytes: &mut Bytes) -> Read<DAffine3> {
    let kind = bytes.text()?;
    let transform = match kind.as_str() {
        "UniformScaleMap" | "ScaleMap" => DAffine3::from_scale(scale(bytes)?),
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let translation = vector(bytes)?;
            DAffine3 { matrix3: DMat3::from_diagonal(scale(bytes)?), translation }
        }
        "TranslationMap" => DAffine3::from_translation(vector(bytes)?),
        "AffineMap" | "UnitaryMap" => affine(bytes)?,
        _ => {
            let fault = bytes.fault(format!("its voxels lie as a `{kind}`, not along straight axes"));
            return Err(Fault {
                remedy: Some("resample it where it is made: even voxels in a box"),
                ..fault
            });
        }
    };
    let size = transform.matrix3.determinant();
    if !transform.is_finite() || size == 0.0 || !size.is_finite() {
        return Err(bytes.fault("its voxels have no size"));
    }
    Ok(transform)
}

fn vector(bytes: &mut Bytes) -> Read<DVec3> {
    Ok(DVec3::new(bytes.f64()?, bytes.f64()?, bytes.f64()?))
}

/// Reads the scale, and skips four vectors derived from it.
fn scale(bytes: &mut Bytes) -> Read<DVec3> {
    let scale = vector(bytes)?;
    bytes.take(4 * 24)?;
    Ok(scale)
}

/// Reads a 4 x 4 matrix in rows. OpenVDB multiplies row vectors from the left, so each row is a column here.
fn affine(bytes: &mut Bytes) -> Read<DAffine3> {
    let mut rows = [DVec3::ZERO; 4];
    for row in &mut rows {
        *row = vector(bytes)?;
        bytes.f64()?;
    }
    Ok(DAffine3 { matrix3: DMat3::from_cols(rows[0], rows[1], rows[2]), translation: rows[3] })
}
