//! Numbers of several leaves side by side. Invariant: what becomes of one does not depend on its neighbours,
//! and is what it becomes alone, to the last bit. All operations are those of `f64`, lane by lane. Their
//! loops are so plain that the compiler has neighbours share instructions.

use std::array;
use std::ops::{Add, Mul, Neg, Sub};

/// Number of lanes: a step waits for its own numbers, and so many wait at once. Eight are hardly faster,
/// and leave more idle where leaves run out.
pub(super) const LANES: usize = 4;

/// Number that the equations of a plate are written in.
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

/// One number of each of several leaves.
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

/// An operator of two numbers, lane by lane.
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
