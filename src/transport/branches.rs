//! Splitting: several random walks branch off one camera ray, which is traced once (Arvo & Kirk 1990,
//! "Particle transport and image synthesis", section 3). Invariant: each number of walks is at least 1.

/// Number of walks that branch off a camera ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Branches {
    /// At each surface that the camera ray meets, at least 1.
    pub at_surfaces: u32,
    /// In fog, at least 1.
    pub in_fog: u32,
}

impl Branches {
    /// One walk at each vertex of the camera ray.
    pub const ONE: Self = Self { at_surfaces: 1, in_fog: 1 };

    /// Mean of the two numbers.
    pub fn mean(self) -> f64 {
        0.5 * f64::from(self.at_surfaces + self.in_fog)
    }
}
