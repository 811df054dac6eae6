//! Alpha masks as geometry. In go masked triangles, out come opaque ones, cut along the contour where alpha
//! equals the cutoff. Invariants: neighbours are cut at identical points of their common edge. A triangle
//! that is wholly visible stays as it is.

mod contour;
mod cut;
mod fading;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

use super::{Mesh, Texture, Triangle};
use crate::diagnostic::{Diagnostic, Loss, Place};
use contour::Window;
use cut::Cutter;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// Maximum distance between an outline and the contour, in texels.
pub const OUTLINE_TOLERANCE_TEXELS: f64 = 0.25;

/// Maximum number of texels under a mesh, repetitions included.
const MOST_TEXELS: i64 = 1 << 27;
/// Maximum distance of its texture coordinates from 0, in texels.
const FARTHEST_TEXEL: f64 = (1 << 18) as f64;

/// Alpha mask of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mask<'a> {
    /// Texture with the alpha.
    texture: &'a Texture,
    /// Alpha of the texture at and above which the surface is visible.
    threshold: f64,
}

impl<'a> Mask<'a> {
    /// Creates a mask that shows the surface where the texture's alpha times `opacity` is at least `cutoff`.
    pub(super) fn new(texture: &'a Texture, cutoff: f64, opacity: f64) -> Self {
        // A cutoff of 0 hides nothing, even with an opacity of 0.
        Self { texture, threshold: if cutoff > 0.0 { cutoff / opacity } else { 0.0 } }
    }
}

/// Vertex on an edge of a triangle or within it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between {
    /// Vertices of the triangle.
    pub(super) corners: [u32; 3],
    /// Weights of the corners; 1 in sum.
    pub(super) weights: [f64; 3],
}

/// Meshes that were cut, for one remark.
#[derive(Debug, Default)]
pub(super) struct Tally(Vec<(String, usize, usize)>);

impl Tally {
    /// Adds a mesh with its number of triangles before and after.
    pub(super) fn add(&mut self, mesh: &str, before: usize, after: usize) {
        if before != after {
            self.0.push((mesh.to_owned(), before, after));
        }
    }

    /// Remark about all of them, if there are any.
    pub(super) fn remark(&self, place: Place) -> Option<Diagnostic> {
        const NAMED: usize = 6;
        let named: Vec<String> = (self.0.iter().take(NAMED))
            .map(|(mesh, before, after)| format!("`{mesh}` from {before} triangles to {after}"))
            .collect();
        let more = match self.0.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let message = format!(
            "masked meshes are cut out along alpha = cutoff, to {OUTLINE_TOLERANCE_TEXELS} texels: {}{more}",
            named.join(", ")
        );
        (!self.0.is_empty()).then(|| Diagnostic::note(place, message))
    }
}

/// Rest of a mesh after the cut.
#[derive(Debug, Default)]
struct Outlined {
    /// New vertices, which follow the old ones.
    added: Vec<Between>,
    /// Triangles of old and new vertices.
    triangles: Vec<[u32; 3]>,
}

/// Mesh without the parts that a mask hides, and its new vertices. All its triangles have one material; there
/// are none if the mask hides all.
pub(super) fn traced_cut_out(mesh: &Mesh, mask: Mask) -> Result<(Mesh, Vec<Between>), Loss> {
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|triangle| triangle.vertices).collect();
    Ok(rebuilt(mesh, outlined(mask, &mesh.uvs, &triangles)?))
}

/// Mesh without the parts where vertex alpha is below `threshold`, and its new vertices.
pub(super) fn faded_cut_out(mesh: &Mesh, threshold: f64) -> (Mesh, Vec<Between>) {
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|triangle| triangle.vertices).collect();
    let (mut cut, added) = rebuilt(mesh, fading::outlined(&mesh.alphas, threshold, &triangles));
    cut.alphas.clear();
    (cut, added)
}

/// Mesh with other triangles, whose new vertices have all attributes interpolated.
fn rebuilt(mesh: &Mesh, Outlined { added, triangles }: Outlined) -> (Mesh, Vec<Between>) {
    let blended = |values: &[Vec3]| -> Vec<Vec3> {
        let blend = |Between { corners, weights }: &Between| {
            let terms = (0..3).map(|corner| weights[corner] * values[corners[corner] as usize].as_dvec3());
            terms.sum::<DVec3>().as_vec3()
        };
        let added = if values.is_empty() { &[] } else { added.as_slice() };
        values.iter().copied().chain(added.iter().map(blend)).collect()
    };
    let blended_uvs = |uvs: &Vec<Vec2>| -> Vec<Vec2> {
        let uvs: Vec<Vec3> = uvs.iter().map(|uv| uv.extend(0.0)).collect();
        blended(&uvs).into_iter().map(Vec3::truncate).collect()
    };
    let alphas: Vec<Vec3> = mesh.alphas.iter().map(|alpha| Vec3::splat(*alpha)).collect();
    // The sign is constant on a triangle.
    let sides: Vec<Vec3> = mesh.tangents.iter().map(|tangent| Vec3::splat(tangent.w)).collect();
    let tangents: Vec<Vec3> = mesh.tangents.iter().map(|tangent| tangent.truncate()).collect();
    let tangents = blended(&tangents).into_iter().zip(blended(&sides));
    let material = mesh.triangles.first().map_or(0, |triangle| triangle.material);
    let cut = Mesh {
        name: mesh.name.clone(),
        positions: blended(&mesh.positions),
        // Opposite normals may cancel; any direction is then valid.
        normals: blended(&mesh.normals).into_iter().map(|normal| normal.normalize_or(Vec3::Y)).collect(),
        uvs: blended_uvs(&mesh.uvs),
        more_uvs: mesh.more_uvs.iter().map(blended_uvs).collect(),
        colors: blended(&mesh.colors),
        alphas: blended(&alphas).into_iter().map(|alpha| alpha.x).collect(),
        tangents: tangents.map(|(tangent, side)| tangent.extend(side.x.signum())).collect(),
        triangles: triangles.into_iter().map(|vertices| Triangle { vertices, material }).collect(),
    };
    (cut, added)
}

/// Visible part of triangles, or the reason why they cannot be cut.
fn outlined(mask: Mask, uvs: &[Vec2], triangles: &[[u32; 3]]) -> Result<Outlined, Loss> {
    let texels_of_texture = DVec2::new(mask.texture.width as f64, mask.texture.height as f64);
    let texels: Vec<DVec2> = uvs.iter().map(|uv| uv.as_dvec2() * texels_of_texture).collect();
    let least = mask.texture.texels.iter().map(|texel| f64::from(texel[3])).fold(f64::INFINITY, f64::min);
    if least >= mask.threshold || triangles.is_empty() {
        return Ok(Outlined { added: Vec::new(), triangles: triangles.to_vec() });
    }
    let used = || triangles.iter().flatten().map(|&vertex| texels[vertex as usize]);
    let low = used().fold(DVec2::INFINITY, DVec2::min);
    let high = used().fold(DVec2::NEG_INFINITY, DVec2::max);
    let is_near = low.min_element() >= -FARTHEST_TEXEL && high.max_element() <= FARTHEST_TEXEL;
    if !is_near {
        return Err(Loss::MaskTooWide);
    }
    // A margin of a texel, so that contours along the window's border are cut away.
    let (low, high) = ((low - 2.5).floor().as_i64vec2(), (high + 1.5).ceil().as_i64vec2());
    if (high.x - low.x) * (high.y - low.y) > MOST_TEXELS {
        return Err(Loss::MaskTooWide);
    }
    let window = Window { columns: low.x..=high.x, rows: low.y..=high.y };
    let alpha = |column: i64, row: i64| mask.texture.texel_alpha(column, row);
    let rings = contour::rings(alpha, mask.threshold, &window).ok_or(Loss::MaskTooFine)?;
    let rings = rings.iter().map(|ring| contour::simplified(ring, OUTLINE_TOLERANCE_TEXELS));
    let is_shown = |at: DVec2| mask.texture.alpha((at / texels_of_texture).as_vec2()) >= mask.threshold;
    let mut cutter = Cutter::new(rings.filter(|ring| ring.len() > 2));
    for &triangle in triangles {
        cutter.cut(triangle, triangle.map(|vertex| texels[vertex as usize]), is_shown);
    }
    Ok(cutter.finish(uvs.len()))
}
