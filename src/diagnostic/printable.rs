//! Text for terminals, which execute control characters. In go names, out comes printable text. Invariant:
//! the only control characters are line ends of the program itself.

use std::fmt::{self, Write};
use std::path::Path;

/// Writer that escapes control characters, as names come from files.
pub(super) struct Printable<'a, W>(pub(super) &'a mut W);

impl<W: Write> Write for Printable<'_, W> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for part in text.split_inclusive(is_obeyed) {
            let plain = part.trim_end_matches(is_obeyed);
            self.0.write_str(plain)?;
            part[plain.len()..]
                .chars()
                .try_for_each(|character| write!(self.0, "{}", character.escape_default()))?;
        }
        Ok(())
    }
}

/// Whether a terminal executes a character: control characters except line ends, and changes of the writing
/// direction.
fn is_obeyed(character: char) -> bool {
    let turns = matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || character.is_control() && character != '\n'
}

/// Path for messages: bytes that are not UTF-8 become `\xff`, control characters are escaped.
pub fn shown(path: &Path) -> impl fmt::Display {
    ShownPath(path)
}

struct ShownPath<'a>(&'a Path);

impl fmt::Display for ShownPath<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut printable = Printable(f);
        self.0.as_os_str().as_encoded_bytes().utf8_chunks().try_for_each(|chunk| {
            printable.write_str(chunk.valid())?;
            chunk.invalid().iter().try_for_each(|byte| write!(printable, "\\x{byte:02x}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_escaped() {
        assert_eq!(shown(Path::new("a b/Ä.exr")).to_string(), "a b/Ä.exr");
        assert_eq!(shown(Path::new("a\x1b[2J\u{202e}b")).to_string(), "a\\u{1b}[2J\\u{202e}b");
    }

    #[test]
    #[cfg(unix)]
    fn bytes_that_are_no_text_can_be_read_off() {
        use std::os::unix::ffi::OsStrExt;
        let path = Path::new(std::ffi::OsStr::from_bytes(b"x\xff/\xc3\xa4\xc3.exr"));
        assert_eq!(shown(path).to_string(), "x\\xff/ä\\xc3.exr");
    }
}
