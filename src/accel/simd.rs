//! Vectors of eight singles. Invariant: every implementation of [`Lanes`] rounds each operation in the same
//! way, so results do not depend on the implementation.
//!
//! A [`Simd`] value proves that its instructions exist on this processor; code with such a value, or with
//! lanes made by it, may use them. Multiplications and additions are never fused: the shared edges of
//! triangles are watertight only because `a * b - c * d` is antisymmetric to the last bit.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Not, Sub};

/// Number of lanes of a vector, of children of a node and of triangles of a block.
pub(super) const WIDTH: usize = 8;

/// `WIDTH` singles in memory, aligned for vector loads.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Eight(pub(super) [f32; WIDTH]);

/// `[f(0), f(1), f(2)]`. Kernels use this rather than `array::map`, with closures marked to be inlined:
/// functions that are not inlined are compiled without the vector instructions.
#[inline(always)]
pub(super) fn three<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// Calls `say` with the number of each bit that is set.
#[inline(always)]
pub(super) fn each_lane(mut lanes: u32, mut say: impl FnMut(usize)) {
    while lanes != 0 {
        say(lanes.trailing_zeros() as usize % WIDTH);
        lanes &= lanes - 1;
    }
}

/// One number or several, with the same operations.
pub(super) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    type Mask: Mask;
    /// `self < other ? self : other`: `other` wherever either is NaN.
    fn min(self, other: Self) -> Self;
    /// `self > other ? self : other`: `other` wherever either is NaN.
    fn max(self, other: Self) -> Self;
    /// `self < other`, false for NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`, false for NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// `self == other`, false for NaN.
    fn eq(self, other: Self) -> Self::Mask;
    /// `mask ? self : other`.
    fn or_else(self, mask: Self::Mask, other: Self) -> Self;
}

/// Boolean values of [`Lanes`].
pub(super) trait Mask:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self>
{
    /// Bit `i` is lane `i`.
    fn bits(self) -> u32;
}

/// An implementation of arithmetic on [`WIDTH`] singles.
pub(super) trait Simd: Copy {
    /// The vector of [`WIDTH`] singles.
    type Lanes: Lanes;
    fn splat(self, value: f32) -> Self::Lanes;
    fn load(self, values: &Eight) -> Self::Lanes;
    fn store(self, lanes: Self::Lanes) -> [f32; WIDTH];
    /// Starts to fetch memory that will be read soon.
    #[inline(always)]
    fn prefetch<T>(self, _soon_read: &T) {}
}

/// A computation that is compiled for each implementation of [`Simd`]. All functions called by `run` must be
/// inlined into it.
pub(super) trait Kernel {
    type Output;
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Plain Rust, for any processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

/// Lanes of [`Portable`].
#[derive(Clone, Copy, Debug)]
pub(super) struct PortableLanes([f32; WIDTH]);

/// Boolean values of [`PortableLanes`]: all bits set, or none.
#[derive(Clone, Copy, Debug)]
pub(super) struct PortableMask([u32; WIDTH]);

impl Simd for Portable {
    type Lanes = PortableLanes;
    #[inline(always)]
    fn splat(self, value: f32) -> PortableLanes {
        PortableLanes([value; WIDTH])
    }
    #[inline(always)]
    fn load(self, values: &Eight) -> PortableLanes {
        PortableLanes(values.0)
    }
    #[inline(always)]
    fn store(self, lanes: PortableLanes) -> [f32; WIDTH] {
        lanes.0
    }
}

impl PortableLanes {
    #[inline(always)]
    fn zip(self, other: Self, operation: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|lane| operation(self.0[lane], other.0[lane])))
    }
    #[inline(always)]
    fn compare(self, other: Self, holds: impl Fn(f32, f32) -> bool) -> PortableMask {
        PortableMask(std::array::from_fn(
            |lane| {
                if holds(self.0[lane], other.0[lane]) { u32::MAX } else { 0 }
            },
        ))
    }
}

/// Implements an operator of lanes or masks, lane by lane.
macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $operation:expr) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, $operation)
            }
        }
    };
}
operator!(PortableLanes, Add, add, |a, b| a + b);
operator!(PortableLanes, Sub, sub, |a, b| a - b);
operator!(PortableLanes, Mul, mul, |a, b| a * b);
operator!(PortableLanes, Div, div, |a, b| a / b);
operator!(PortableMask, BitAnd, bitand, |a, b| a & b);
operator!(PortableMask, BitOr, bitor, |a, b| a | b);
operator!(PortableMask, BitXor, bitxor, |a, b| a ^ b);

impl Lanes for PortableLanes {
    type Mask = PortableMask;
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a < b)
    }
    #[inline(always)]
    fn le(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a == b)
    }
    #[inline(always)]
    fn or_else(self, mask: PortableMask, other: Self) -> Self {
        Self(std::array::from_fn(|lane| if mask.0[lane] != 0 { self.0[lane] } else { other.0[lane] }))
    }
}

impl PortableMask {
    #[inline(always)]
    fn zip(self, other: Self, operation: impl Fn(u32, u32) -> u32) -> Self {
        Self(std::array::from_fn(|lane| operation(self.0[lane], other.0[lane])))
    }
}
impl Not for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        self.zip(self, |a, _| !a)
    }
}
impl Mask for PortableMask {
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..WIDTH).fold(0, |bits, lane| bits | (self.0[lane] & 1) << lane)
    }
}

/// A single double as a lane: kernels then compute in double precision.
impl Lanes for f64 {
    type Mask = bool;
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn or_else(self, mask: bool, other: Self) -> Self {
        if mask { self } else { other }
    }
}
impl Mask for bool {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
}
