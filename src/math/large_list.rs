//! Lists that give their memory back when they are dropped. In goes a number of values, out comes an empty
//! list for them. Invariant: nothing but its capacity differs from that of other lists.

/// Size from which glibc maps memory by itself, and unmaps it when it is freed, whatever was freed before
/// (`M_MMAP_THRESHOLD` in mallopt(3)). Once a smaller block has been freed, it keeps later ones of its size.
pub const MAPPED_BYTES: usize = (32 << 20) + (1 << 16);
/// Size below which it is not worth a call of the system.
const LARGE_BYTES: usize = 4 << 20;

/// Empty list for so many values. A large one reserves more addresses than it needs, which take no memory as
/// nothing is written there.
pub fn large_list<T>(count: usize) -> Vec<T> {
    let mut list = Vec::new();
    let is_large = count.saturating_mul(size_of::<T>()) >= LARGE_BYTES;
    // Under a limit of memory there may be no such room.
    if !is_large || list.try_reserve_exact(count.max(MAPPED_BYTES / size_of::<T>())).is_err() {
        list.reserve_exact(count);
    }
    list
}
