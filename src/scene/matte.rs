//! Ids of Cryptomatte. In goes a name, out come 32 bits that are also a finite single-precision number.
//! Invariant: equal names have equal ids, in any scene and any program.

/// Id of a name: its MurmurHash3, with one bit flipped where it would not be a normal number (Friedman and
/// Jones 2015, "Fully automatic ID mattes with support for motion blur and transparency"; Cryptomatte
/// specification 1.2.0, "ID generation" and "uint32_to_float32"). A channel stores it as an `f32`.
pub fn matte_id(name: &str) -> u32 {
    const EXPONENT: u32 = 0xff << 23;
    let hash = murmur3(name.as_bytes());
    // An exponent of zeros marks zeros and denormals, one of ones infinities and NaN.
    if hash & EXPONENT == 0 || hash & EXPONENT == EXPONENT { hash ^ (1 << 23) } else { hash }
}

/// MurmurHash3, x86, 32 bits, seed 0 (Appleby 2011).
pub fn murmur3(bytes: &[u8]) -> u32 {
    let scramble = |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (words, rest) = bytes.as_chunks::<4>();
    let hash = words.iter().fold(0_u32, |hash, word| {
        let mixed = hash ^ scramble(u32::from_le_bytes(*word));
        mixed.rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    let hash = hash ^ scramble(u32::from_le_bytes(last)) ^ bytes.len() as u32;
    let hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    let hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    hash ^ (hash >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published vectors of the 32-bit hash with seed 0, and those of the specification's
    /// example of a manifest.
    #[test]
    fn known_hashes() {
        for (text, hash) in [
            ("", 0),
            ("test", 0xba6b_d213),
            ("Hello, world!", 0xc036_3e43),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
            ("hello", 0x248b_fa47),
            ("bunny", 0x1385_1a76),
            ("default", 0x42c9_679f),
        ] {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text}");
        }
    }

    #[test]
    fn every_id_is_a_normal_number() {
        for number in 0..100_000 {
            let id = f32::from_bits(matte_id(&format!("leaf.{number}")));
            assert!(id.is_normal(), "{number}: {id}");
        }
        assert_eq!(matte_id(""), 1 << 23, "whose hash is 0");
    }
}
