//! Hash of a whole file, stored in the file itself. In go its bytes, out come 64 digits. Invariant: any byte
//! that is changed, added or removed, in the header or the pixels, changes it.

use sha2::{Digest, Sha256};
use std::ops::Range;

pub(super) const NAME: &str = "sunfleck:fileHash";
/// Placeholder for the digits while the hash is computed.
pub(super) const PLACEHOLDER: &str = "0000000000000000000000000000000000000000000000000000000000000000";
/// Bytes before the attribute's value: name, 0, type, 0, size as i32.
const HEAD: &[u8] = b"sunfleck:fileHash\0string\0\x40\0\0\0";

/// Replaces the placeholder by the hash; `None` without a placeholder.
pub(super) fn seal(file: &mut [u8]) -> Option<()> {
    let digits = digits(file)?;
    let hash = hash(file, &digits);
    file[digits].copy_from_slice(hash.as_bytes());
    Some(())
}

/// Whether a file is unchanged since `seal`.
pub(super) fn is_whole(file: &[u8]) -> bool {
    digits(file).is_some_and(|digits| hash(file, &digits).as_bytes() == &file[digits])
}

/// Range of the digits: after the first such head, which is in the header, before any pixel.
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
