//! Instruction sets. In goes a kernel, out comes its answer. Invariant: the answer is the same on every
//! level.

#[cfg(target_arch = "x86_64")]
use super::avx2::Avx2;
use super::simd::{Kernel, Portable, Simd};

/// Implementation that serves this processor.
#[derive(Clone, Copy, Debug)]
pub(super) enum Level {
    /// Plain Rust.
    Portable(Portable),
    /// x86-64 with AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

impl Level {
    /// The fastest one there is.
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

/// Loops over slices that are worth compiling for the widest vectors there are. Everything below `run` has to
/// be inlined into it, and no sum may depend on the width.
pub trait Vectorized {
    /// Does it.
    fn run(self);
}

/// Does it by the vectors of this processor.
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
