//! SIMD lanes, one leaf each. In go numbers of several leaves, out come results lane by lane. Invariant: each
//! lane has the same bits as a leaf alone. All operations are those of `f64`, in loops so simple that the
//! compiler vectorizes them.

use std::array;
use std::ops::{Add, Mul, Neg, Sub};

/// Number of lanes, which hides the latency of operations. Eight are hardly faster, and leave more idle at
/// the end.
pub(super) const LANES: usize = 4;

/// Number type of a plate's equations.
pub(super) trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
{
    fn map(self, of: impl Fn(f64) -> f64) -> Self;
}

impl Number for f64 {
    fn map(self, of: impl Fn(f64) -> f64) -> Self {
        of(self)
    }
}

/// One number a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lanes(pub(super) [f64; LANES]);

impl Lanes {
    fn with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        Self(array::from_fn(|lane| of(self.0[lane], other.0[lane])))
    }
}

impl Number for Lanes {
    fn map(self, of: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(of))
    }
}

/// Implements a binary operator, lane by lane.
macro_rules! operator {
    ($trait:ident, $method:ident, $operation:expr) => {
        impl $trait for Lanes {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.with(other, $operation)
            }
        }
    };
}
operator!(Add, add, |a, b| a + b);
operator!(Sub, sub, |a, b| a - b);
operator!(Mul, mul, |a, b| a * b);

impl Mul<f64> for Lanes {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self.map(|a| a * factor)
    }
}

impl Neg for Lanes {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}
