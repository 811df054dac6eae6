//! Instruction sets. In goes a kernel, out comes its result. Invariant: the result is the same for every
//! instruction set.

#[cfg(target_arch = "x86_64")]
use super::avx2::Avx2;
use super::simd::{Kernel, Portable, Simd};

/// Instruction set of this processor.
#[derive(Clone, Copy, Debug)]
pub(super) enum Level {
    /// Plain Rust.
    Portable(Portable),
    /// x86-64 with AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

impl Level {
    /// Detects the fastest available one.
    pub(super) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = Avx2::detect() {
            return Self::Avx2(avx2);
        }
        Self::Portable(Portable)
    }

    #[inline]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Self::Portable(simd) => kernel.run(simd),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(simd) => simd.run(kernel),
        }
    }
}

/// Loops over slices, compiled for the widest available vectors. All functions called by `run` must be
/// inlined into it, and no sum may depend on the width.
pub trait Vectorized {
    /// Runs the loops.
    fn run(self);
}

/// Runs the loops with the vectors of this processor.
pub fn vectorized(work: impl Vectorized) {
    Level::detect().run(Loops(work));
}

struct Loops<W>(W);

impl<W: Vectorized> Kernel for Loops<W> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.0.run();
    }
}
