//! Shapes of a scene file. In goes RON, out come shapes. Invariant: docs/scene-format.md describes every
//! field.

use super::named::Named;
use super::number::{Degrees, Number, Positive};
use super::replacement::Replacement;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A shape.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum Shape {
    /// A Wavefront OBJ file, relative to the scene file.
    Obj(PathBuf),
    /// An OBJ file, some of whose materials are replaced.
    #[non_exhaustive]
    ObjWith {
        /// Relative to the scene file.
        file: PathBuf,
        /// Replacements, by names of the file's materials.
        materials: Named<Replacement>,
    },
    /// A square in the x-z plane, centred, facing +y.
    #[non_exhaustive]
    Quad {
        /// Length of an edge.
        size_m: Number<Positive>,
    },
    /// A rectangle in the x-z plane, centred, facing +y, for pictures of leaves, with its top towards -z.
    #[non_exhaustive]
    Card {
        /// Length along z, from bottom to top.
        length_m: Number<Positive>,
        /// Width along x.
        width_m: Number<Positive>,
    },
    /// A cube, centred.
    #[non_exhaustive]
    Cube {
        /// Length of an edge.
        size_m: Number<Positive>,
    },
    /// A sphere, centred.
    #[non_exhaustive]
    Sphere {
        /// Radius.
        radius_m: Number<Positive>,
    },
    /// A leaf in the x-z plane, centred, facing +y, its tip towards -z.
    #[non_exhaustive]
    Leaf {
        /// Length from stalk to tip.
        length_m: Number<Positive>,
        /// Width at the widest place.
        width_m: Number<Positive>,
        /// Total angle by which it bends down along its length.
        #[serde(default)]
        curl_deg: Number<Degrees>,
        /// Angle by which each half is folded up about the midrib.
        #[serde(default)]
        fold_deg: Number<Degrees>,
    },
}

impl Shape {
    /// Creates a square.
    pub fn quad(size_m: f64) -> Self {
        Self::Quad { size_m: size_m.into() }
    }

    /// Creates a rectangle for pictures of leaves.
    pub fn card(length_m: f64, width_m: f64) -> Self {
        Self::Card { length_m: length_m.into(), width_m: width_m.into() }
    }

    /// Creates a cube.
    pub fn cube(size_m: f64) -> Self {
        Self::Cube { size_m: size_m.into() }
    }

    /// Creates a sphere.
    pub fn sphere(radius_m: f64) -> Self {
        Self::Sphere { radius_m: radius_m.into() }
    }

    /// Creates a flat leaf.
    pub fn leaf(length_m: f64, width_m: f64) -> Self {
        Self::Leaf {
            length_m: length_m.into(),
            width_m: width_m.into(),
            curl_deg: Number::default(),
            fold_deg: Number::default(),
        }
    }

    /// Names an OBJ file, some of whose materials are replaced.
    pub fn obj_with(file: impl Into<PathBuf>, materials: Named<Replacement>) -> Self {
        Self::ObjWith { file: file.into(), materials }
    }

    /// OBJ file of the shape, and its replacements of materials.
    pub fn obj(&self) -> Option<(&PathBuf, Option<&Named<Replacement>>)> {
        match self {
            Self::Obj(file) => Some((file, None)),
            Self::ObjWith { file, materials } => Some((file, Some(materials))),
            Self::Quad { .. }
            | Self::Card { .. }
            | Self::Cube { .. }
            | Self::Sphere { .. }
            | Self::Leaf { .. } => None,
        }
    }
}
