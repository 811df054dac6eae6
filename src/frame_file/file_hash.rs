//! The fingerprint of a whole file, which stands in the file itself. In go its bytes, out come 64 digits.
//! Invariant: any byte changed, added or taken away changes it, in the header as in the pixels.

use sha2::{Digest, Sha256};
use std::ops::Range;

/// The attribute's name.
pub(super) const NAME: &str = "sunfleck:fileHash";
/// Placeholder of the digits while the hash is taken.
pub(super) const PLACEHOLDER: &str = "0000000000000000000000000000000000000000000000000000000000000000";
/// Name, 0, type, 0, size as i32: what stands before an attribute's value.
const HEAD: &[u8] = b"sunfleck:fileHash\0string\0\x40\0\0\0";

/// Puts the hash in the place of the placeholder; `None` if there is none.
pub(super) fn seal(file: &mut [u8]) -> Option<()> {
    let digits = digits(file)?;
    let hash = hash(file, &digits);
    file[digits].copy_from_slice(hash.as_bytes());
    Some(())
}

/// Whether a file is what was sealed, to the last bit.
pub(super) fn is_whole(file: &[u8]) -> bool {
    digits(file).is_some_and(|digits| hash(file, &digits).as_bytes() == &file[digits])
}

/// Range of the digits: behind the first such head, which the header has before any pixel.
fn digits(file: &[u8]) -> Option<Range<usize>> {
    let start = file.windows(HEAD.len()).position(|window| window == HEAD)? + HEAD.len();
    let digits = start..start + PLACEHOLDER.len();
    (digits.end <= file.len()).then_some(digits)
}

fn hash(file: &[u8], digits: &Range<usize>) -> String {
    let mut hash = Sha256::new();
    hash.update(&file[..digits.start]);
    hash.update(PLACEHOLDER);
    hash.update(&file[digits.end..]);
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_counts() {
        let mut file = [b"before".as_slice(), HEAD, PLACEHOLDER.as_bytes(), b"behind"].concat();
        assert!(!is_whole(&file));
        assert_eq!(seal(&mut file), Some(()));
        assert!(is_whole(&file));
        for at in 0..file.len() {
            file[at] ^= 1;
            assert!(!is_whole(&file), "byte {at}");
            file[at] ^= 1;
        }
        file.push(0);
        assert!(!is_whole(&file));
        assert!(!is_whole(b"nothing") && seal(&mut [0; 8]).is_none());
    }
}
