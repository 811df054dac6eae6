//! Normal of bumps for specular reflection. In go the geometric normal, the direction of the eye and a bent
//! normal, out comes one that is bent less. Invariant: light that it mirrors towards the eye comes from the
//! front of the surface.

use glam::DVec3;

/// Minimum cosine of mirrored light, and the same as a share of the eye's cosine.
const LEAST: f64 = 0.01;
const LEAST_OF_EYE: f64 = 0.9;

/// Normal between the bent one and that of the surface, bent as far as its mirror direction stays above the
/// surface (Cycles 5.0, `ensure_valid_specular_reflection`). All are unit vectors; the surface's faces the
/// eye.
pub fn specular_normal(surface: DVec3, to_eye: DVec3, bent: DVec3) -> DVec3 {
    let mirrored = 2.0 * bent.dot(to_eye) * bent - to_eye;
    let up = to_eye.dot(surface);
    let least = (LEAST_OF_EYE * up).min(LEAST);
    if surface.dot(mirrored) >= least {
        return bent;
    }
    // With the surface's normal along z and the bent one in the plane of x and z, z of the result solves a
    // quadratic equation in z^2: `4 a z^4 - 2 b z^2 + c = 0`.
    let axis = (bent - bent.dot(surface) * surface).try_normalize().unwrap_or(bent);
    let across = to_eye.dot(axis);
    let a = across * across + up * up;
    let (b, c) = (2.0 * (a + up * least), (least + up).powi(2));
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let squared = (0.25 * (if across < 0.0 { b + root } else { b - root }) / a).clamp(0.0, 1.0);
    (1.0 - squared).sqrt() * axis + squared.sqrt() * surface
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(angle: f64) -> DVec3 {
        DVec3::new(angle.sin(), 0.0, angle.cos())
    }

    #[test]
    fn what_is_mirrored_comes_from_before_the_surface() {
        for eye in [-1.5, -0.9, 0.0, 0.4, 1.2] {
            for bend in [-2.0, -1.2, -0.3, 0.0, 0.2, 1.0, 1.9] {
                let (to_eye, bent) = (at(eye), at(bend));
                let normal = specular_normal(DVec3::Z, to_eye, bent);
                let up = (2.0 * normal.dot(to_eye) * normal - to_eye).z;
                let least = LEAST.min(LEAST_OF_EYE * to_eye.z);
                assert!(up > least - 1e-9 && (normal.length() - 1.0).abs() < 1e-9, "{eye} {bend}: {normal}");
                let is_bent = (2.0 * bent.dot(to_eye) * bent - to_eye).z >= least;
                assert!(
                    is_bent == (normal == bent) && (is_bent || (up - least).abs() < 1e-9),
                    "{eye} {bend}"
                );
            }
        }
    }
}
