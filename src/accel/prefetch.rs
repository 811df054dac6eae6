//! Prefetch hints. In goes a reference, and the processor begins to load its memory. Invariant: no result
//! depends on a hint.
#![allow(unsafe_code, reason = "a hint to the processor, which can do no harm")]

/// Bytes that are loaded together.
#[cfg(target_arch = "x86_64")]
const CACHE_LINE: usize = 64;

/// Loads memory ahead of its use.
#[inline(always)]
pub fn prefetch<T>(soon_read: &T) {
    #[cfg(target_arch = "x86_64")]
    for offset in (0..size_of::<T>()).step_by(CACHE_LINE) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a hint, for any address; this one lies in what is borrowed.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(soon_read).cast::<i8>().add(offset)) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = soon_read;
}
