//! Images of materials. In go texture coordinates, out come colours and alphas. Invariant: `width * height`
//! texels, all finite, in linear light.

use crate::color::{Rgb, Texels};
pub use crate::description::gltf::Wrap;
use glam::{DVec2, DVec4, Vec2};

/// An RGBA image in linear Rec. 709, top row first.
#[derive(Clone, Debug)]
pub struct Texture {
    /// File name or the author's name.
    pub name: String,
    /// Texels a row, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Linear colour, alpha last, row by row from the top.
    pub texels: Texels,
    /// Wrap mode across and down.
    pub wrap: [Wrap; 2],
}

impl Texture {
    /// Bilinear colour at `uv`; (0, 0) is the top left corner of the top left texel.
    pub fn color(&self, uv: Vec2) -> Rgb {
        self.look_up(uv).truncate()
    }

    /// Bilinear alpha at `uv`.
    pub fn alpha(&self, uv: Vec2) -> f64 {
        self.look_up(uv).w
    }

    /// Alpha of a texel, after wrapping.
    pub(super) fn texel_alpha(&self, column: i64, row: i64) -> f64 {
        let (column, row) = (self.wrap[0].index(column, self.width), self.wrap[1].index(row, self.height));
        f64::from(self.texels.get(row * self.width + column)[3])
    }

    /// Whether any texel is not opaque.
    pub fn has_alpha(&self) -> bool {
        self.texels.iter().any(|texel| texel[3] < 1.0)
    }

    /// Indices of the four texels around `uv`, row by row, and the fractions between them.
    pub(super) fn between(&self, uv: Vec2) -> ([usize; 4], DVec2) {
        let x = uv.x * self.width as f32 - 0.5;
        let y = uv.y * self.height as f32 - 0.5;
        let (column, row) = (x.floor(), y.floor());
        let (right, below) = (f64::from(x - column), f64::from(y - row));
        let next = |wrap: Wrap, place: f32, count: usize| {
            [0, 1].map(|step| wrap.index((place as i64).saturating_add(step), count))
        };
        let [left, right_of_it] = next(self.wrap[0], column, self.width);
        let [top, bottom] = next(self.wrap[1], row, self.height).map(|row| row * self.width);
        let texels = [top + left, top + right_of_it, bottom + left, bottom + right_of_it];
        (texels, DVec2::new(right, below))
    }

    /// First bytes of the texels above and below `uv`, to prefetch them.
    pub fn memory_at(&self, uv: Vec2) -> [Option<&u8>; 2] {
        let ([above, _, below, _], _) = self.between(uv);
        [above, below].map(|texel| self.texels.byte(texel))
    }

    fn look_up(&self, uv: Vec2) -> DVec4 {
        let (texels, at) = self.between(uv);
        self.texels.between(texels, at)
    }
}

impl Wrap {
    /// Wraps any texel number into the image.
    fn index(self, number: i64, count: usize) -> usize {
        let count = count as i64;
        if (0..count).contains(&number) {
            return number as usize;
        }
        let wrapped = match self {
            Self::Repeat => number.rem_euclid(count),
            Self::Clamp => number.clamp(0, count - 1),
            Self::Mirror => {
                let folded = number.rem_euclid(2 * count);
                folded.min(2 * count - 1 - folded)
            }
        };
        wrapped as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn black_and_white(wrap: Wrap) -> Texture {
        Texture {
            name: String::new(),
            width: 2,
            height: 1,
            texels: vec![[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]].into(),
            wrap: [wrap; 2],
        }
    }

    #[test]
    fn texel_centres_are_exact_and_between_is_linear() {
        let texture = black_and_white(Wrap::Clamp);
        assert_eq!(texture.color(Vec2::new(0.25, 0.5)), Rgb::ZERO);
        assert_eq!(texture.color(Vec2::new(0.75, 0.5)), Rgb::ONE);
        assert_eq!(texture.color(Vec2::new(0.5, 0.5)), Rgb::splat(0.5));
    }

    #[test]
    fn no_place_is_too_far() {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            for far in [f32::MAX, f32::MIN, f32::INFINITY, f32::NAN] {
                black_and_white(wrap).color(Vec2::new(far, -far));
            }
        }
    }

    #[test]
    fn edges_wrap_as_asked() {
        let left_edge = Vec2::new(0.0, 0.5);
        assert_eq!(black_and_white(Wrap::Repeat).color(left_edge), Rgb::splat(0.5));
        assert_eq!(black_and_white(Wrap::Clamp).color(left_edge), Rgb::ZERO);
        assert_eq!(black_and_white(Wrap::Mirror).color(left_edge), Rgb::ZERO);
    }
}
