//! A dielectric that is a share of a surface: a thin sheet, or one face of a body. In go directions and the
//! normal on the side of the eye, out comes a BSDF. Invariant: reflection and transmission are sampled from
//! the densities that `pdf` returns.

use super::{Interface, ThinDielectric};
use crate::color::Rgb;
use glam::{DVec2, DVec3};

/// A rough dielectric.
#[derive(Clone, Copy, Debug)]
pub enum Dielectric {
    /// Thin sheet: two faces at one place.
    Thin(ThinDielectric),
    /// Interface: one face.
    Interface(Interface),
}

impl Dielectric {
    /// glTF's alpha of its reflection, and of its transmission.
    pub fn alphas(&self) -> [f64; 2] {
        match self {
            Self::Thin(sheet) => sheet.alphas(),
            Self::Interface(face) => face.alphas(),
        }
    }

    /// Albedos of reflection and transmission, for the cosine of the eye.
    pub fn albedos(&self, cos: f64) -> [Rgb; 2] {
        match self {
            Self::Thin(sheet) => sheet.albedos(cos),
            Self::Interface(face) => face.albedos(cos),
        }
    }

    /// BSDF, 1/sr; both directions point away from the surface, `to_eye` on the normal's side.
    pub fn bsdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> Rgb {
        match self {
            Self::Thin(sheet) => sheet.bsdf(normal, to_eye, to_light),
            Self::Interface(face) => face.bsdf(normal, to_eye, to_light),
        }
    }

    /// Samples a direction to the light by two uniform numbers, in transmission if `is_through`, otherwise in
    /// reflection.
    pub fn sample(&self, normal: DVec3, to_eye: DVec3, is_through: bool, u: DVec2) -> DVec3 {
        match self {
            Self::Thin(sheet) => sheet.sample(normal, to_eye, is_through, u),
            Self::Interface(face) => face.sample(normal, to_eye, is_through, u),
        }
    }

    /// Probability densities of [`Dielectric::sample`] for a direction, 1/sr: in reflection and in
    /// transmission.
    pub fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> [f64; 2] {
        match self {
            Self::Thin(sheet) => sheet.pdf(normal, to_eye, to_light),
            Self::Interface(face) => face.pdf(normal, to_eye, to_light),
        }
    }

    /// Direction from which a smooth dielectric transmits light.
    pub fn straight(&self, normal: DVec3, to_eye: DVec3) -> DVec3 {
        match self {
            Self::Thin(_) => -to_eye,
            Self::Interface(face) => face.straight(normal, to_eye),
        }
    }
}
