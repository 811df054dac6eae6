//! Shadows of the bumps of a normal map. In go two normals and a direction, out comes the share of light that
//! arrives. Invariant: 1 for an unbent normal, and continuous except where bumps face away.

use glam::DVec3;

/// Share of light from a direction that reaches diffuse bumps: the shadowing of microfacets as steep as the
/// bent normal (Conty Estevez, Lecocq and Stein 2019, "A microfacet-based shadowing function to solve the
/// bump terminator problem", as in Cycles). It is 0 if light and bumps are on different sides of the surface.
pub fn bump_shadow(unbent: DVec3, bent: DVec3, to_light: DVec3) -> f64 {
    if unbent.dot(to_light) * unbent.dot(bent) * bent.dot(to_light) < 0.0 {
        return 0.0;
    }
    let squared_tangent = |cos: f64| (1.0 / (cos * cos).max(1e-12) - 1.0).max(0.0);
    let steepness = (0.125 * squared_tangent(unbent.dot(bent))).min(1.0);
    2.0 / (1.0 + (1.0 + steepness * squared_tangent(unbent.dot(to_light))).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(angle: f64) -> DVec3 {
        DVec3::new(angle.sin(), 0.0, angle.cos())
    }

    #[test]
    fn what_is_not_bent_has_no_shadows() {
        for angle in [-1.5, 0.0, 0.7, 1.5, 2.0] {
            assert_eq!(bump_shadow(DVec3::Z, DVec3::Z, at(angle)), 1.0);
        }
    }

    #[test]
    fn bumps_that_face_into_the_surface_are_dark() {
        assert_eq!(bump_shadow(DVec3::Z, at(2.0), at(1.0)), 0.0);
        assert!(bump_shadow(DVec3::Z, at(1.0), at(2.8)) > 0.0);
    }

    /// Measured in Blender 5.3: a plane with and without *Bump Map Correction*.
    #[test]
    fn shadows_are_those_of_cycles() {
        for (bent, angle, share) in
            [(0.3, 1.45, 0.8525), (0.6, -0.9, 0.9778), (1.0, 1.2, 0.7316), (1.0, 1.53, 0.1377)]
        {
            let found = bump_shadow(DVec3::Z, at(bent), at(angle));
            assert!((found - share).abs() < 2e-4, "{bent} {angle}: {found}");
        }
    }
}
