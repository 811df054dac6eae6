//! Statements of OBJ and MTL files. In go bytes, out come statements. Invariant: every statement has its
//! first line's number, for any encoding, line ends and continuations.

use std::borrow::Cow;

/// Text of a file: UTF-8, UTF-16, or Latin-1 in lines that are not UTF-8. UTF-16 is recognized by its byte
/// order mark, or by a zero beside the first letter. All line ends become line feeds.
pub(super) fn decoded(bytes: Vec<u8>) -> String {
    let text = match bytes.as_slice() {
        [0xff, 0xfe, rest @ ..] => from_utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => from_utf16(rest, u16::from_be_bytes),
        [1..=255, 0, ..] => from_utf16(&bytes, u16::from_le_bytes),
        [0, 1..=255, ..] => from_utf16(&bytes, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => from_utf8_or_latin1(rest.to_vec()),
        _ => from_utf8_or_latin1(bytes),
    };
    if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n") } else { text }
}

fn from_utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units).map(|char| char.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

fn from_utf8_or_latin1(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap_or_else(|error| {
        let lines = error.as_bytes().split_inclusive(|byte| matches!(byte, b'\n' | b'\r'));
        let decode = |line| match std::str::from_utf8(line) {
            Ok(text) => Cow::Borrowed(text),
            // Latin-1 is the first 256 characters of Unicode.
            Err(_) => Cow::Owned(line.iter().map(|&byte| char::from(byte)).collect()),
        };
        lines.map(decode).collect()
    })
}

/// Statement of one line, or of several joined by `\`.
pub(super) struct Statement<'a> {
    /// The first line, from 1.
    pub(super) line: usize,
    text: Cow<'a, str>,
}

impl Statement<'_> {
    /// First word, in its original case.
    pub(super) fn keyword(&self) -> &str {
        self.text.split_whitespace().next().unwrap_or_default()
    }

    /// Text after the keyword, with spaces and signs, as in names.
    pub(super) fn rest(&self) -> &str {
        self.text.trim_start()[self.keyword().len()..].trim()
    }

    /// Words after the keyword, up to a comment.
    pub(super) fn words(&self) -> impl Iterator<Item = &str> {
        self.rest().split_whitespace().take_while(|word| !word.starts_with('#'))
    }

    /// Words of a statement of numbers, where a comment needs no space before it.
    pub(super) fn numbers(&self) -> impl Iterator<Item = &str> {
        self.rest().split('#').next().unwrap_or_default().split_whitespace()
    }
}

/// Statements of a text, without comments and empty lines.
pub(super) fn statements(text: &str) -> impl Iterator<Item = Statement<'_>> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.find(|(_, line)| {
            let line = line.trim_start();
            !line.is_empty() && !line.starts_with('#')
        })?;
        let mut text = Cow::Borrowed(first);
        while text.trim_end().ends_with('\\') {
            let joined = text.to_mut();
            joined.truncate(joined.trim_end().len() - 1);
            joined.push(' ');
            let Some((_, next)) = lines.next() else { break };
            joined.push_str(next);
        }
        Some(Statement { line: index + 1, text })
    })
}

/// Parses a number that is finite as `f32`.
pub(super) fn number(word: &str) -> Option<f32> {
    word.parse().ok().filter(|number: &f32| number.is_finite())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Vec<(usize, String, Vec<String>)> {
        let text = decoded(bytes.to_vec());
        let read = |statement: Statement<'_>| {
            let words = statement.words().map(str::to_owned).collect();
            (statement.line, statement.keyword().to_owned(), words)
        };
        statements(&text).map(read).collect()
    }

    #[test]
    fn every_encoding_and_line_end_says_the_same() {
        let plain = "# a\nv 1 2 3\n\n\tf\t1 2 3 # the face\nv 4 5 6";
        let expected = read(plain.as_bytes());
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        assert_eq!(expected[1], (4, String::from("f"), words(&["1", "2", "3"])));
        let utf16: Vec<u16> = std::iter::once(0xfeff).chain(plain.encode_utf16()).collect();
        let mut with_mark = b"\xef\xbb\xbf".to_vec();
        with_mark.extend(plain.as_bytes());
        for bytes in [
            plain.replace('\n', "\r").into_bytes(),
            plain.replace('\n', "\r\n").into_bytes(),
            with_mark,
            utf16.iter().flat_map(|unit| unit.to_le_bytes()).collect(),
            utf16.iter().flat_map(|unit| unit.to_be_bytes()).collect(),
            utf16[1..].iter().flat_map(|unit| unit.to_le_bytes()).collect(),
            utf16[1..].iter().flat_map(|unit| unit.to_be_bytes()).collect(),
            plain.bytes().map(|byte| if byte == b'a' { 0xe4 } else { byte }).collect(),
        ] {
            assert_eq!(read(&bytes), expected);
        }
    }

    #[test]
    fn a_backslash_joins_lines_and_their_numbers_stay_true() {
        let read = read(b"f 1 \\\n 2 \\  \n3\nv 1 2 3\nf 4 \\");
        assert_eq!(read[0], (1, String::from("f"), ["1", "2", "3"].map(String::from).to_vec()));
        assert_eq!((read[1].0, read[2].0), (4, 5));
    }

    #[test]
    fn long_continuations_take_no_long_time() {
        let many = "f \\\n".repeat(200_000);
        assert_eq!(statements(&many).count(), 1);
    }

    #[test]
    fn names_keep_their_spaces_and_latin_letters() {
        let text = decoded(b"usemtl  M\xfcller #25 \n".to_vec());
        assert_eq!(statements(&text).next().unwrap().rest(), "Müller #25");
    }
}
