//! Julia set on a sun's disc, coloured by escape time. In goes a point, out comes a colour. Invariant: it is
//! nowhere black, so there is always a picture.

use super::Track;
use crate::color::Rgb;
use glam::DVec2;

/// The Julia set of `z^2 + c`.
#[derive(Clone, Debug)]
pub struct Julia {
    /// Real part of `c`.
    pub real: Track<f64>,
    /// Imaginary part of `c`.
    pub imaginary: Track<f64>,
    /// Maximum number of iterations; points that have not escaped by then count as inside.
    pub iterations: u32,
}

impl Julia {
    /// Whether it is constant.
    pub fn is_still(&self) -> bool {
        self.real.is_constant() && self.imaginary.is_constant()
    }

    /// Colour at points of the unit disc, whose edge is a circle around the origin outside of which every
    /// point escapes.
    pub fn color_at(&self, time_s: f64) -> impl Fn(DVec2) -> Rgb + use<> {
        let c = DVec2::new(self.real.at(time_s), self.imaginary.at(time_s));
        // |z| > R with R^2 - |c| = R makes |z^2 + c| > |z|.
        let escape_radius = 0.5 * (1.0 + (1.0 + 4.0 * c.length()).sqrt());
        let iterations = self.iterations;
        move |p| warm(escape_time(p * escape_radius, c, iterations))
    }
}

/// Iterations until `z` is far away, relative to the maximum; continuous.
fn escape_time(mut z: DVec2, c: DVec2, iterations: u32) -> f64 {
    // Well beyond any escape radius, for an accurate logarithm.
    const FAR: f64 = 1e4;
    for iteration in 0..iterations {
        if z.length_squared() > FAR * FAR {
            let beyond = (z.length().ln() / FAR.ln()).log2();
            return ((f64::from(iteration) - beyond).max(0.0) / f64::from(iterations)).min(1.0);
        }
        z = DVec2::new(z.x * z.x - z.y * z.y, 2.0 * z.x * z.y) + c;
    }
    1.0
}

/// Colour ramp from dark red over yellow to white.
fn warm(x: f64) -> Rgb {
    let step = |from: f64| (3.0 * x - from).clamp(0.0, 1.0);
    Rgb::new(step(0.0).max(0.01), step(1.0), step(2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With `c = 0` the set is the unit disc itself: inside white, outside not, and darker further out.
    #[test]
    fn without_a_constant_it_is_a_disc() {
        let julia = Julia { real: 0.0.into(), imaginary: 0.0.into(), iterations: 100 };
        let color = julia.color_at(0.0);
        assert_eq!(color(DVec2::new(0.6, -0.7)), Rgb::ONE);
        assert_eq!(escape_time(DVec2::new(0.0, 0.999), DVec2::ZERO, 100), 1.0);
        let outside = [1.0001, 1.001, 1.01, 1.5].map(|r| escape_time(DVec2::new(r, 0.0), DVec2::ZERO, 100));
        assert!(outside[0] < 1.0 && outside.windows(2).all(|pair| pair[0] > pair[1]), "{outside:?}");
    }

    #[test]
    fn nowhere_black() {
        let julia = Julia { real: (-2.0).into(), imaginary: 2.0.into(), iterations: 1 };
        let color = julia.color_at(0.0);
        assert!((0..100).all(|i| color(DVec2::new(f64::from(i) / 100.0, 0.2)).x > 0.0));
    }
}
