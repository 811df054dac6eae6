//! Quoting for shells. In goes text, out come words. Invariant: a POSIX shell reads a quoted text as one word
//! with that text.

/// Characters that never need quotes.
const PLAIN: &str = "_@%+=:,./-";

/// Text quoted for a shell, where necessary.
pub(super) fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || PLAIN.contains(c);
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text.to_owned(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

/// Command line of these words, with `variable` in place of `mark`.
pub(super) fn command_line(words: &[String], mark: char, variable: &str) -> String {
    let word = |word: &String| {
        let parts: Vec<String> =
            word.split(mark).map(|part| if part.is_empty() { String::new() } else { quoted(part) }).collect();
        if word.is_empty() { quoted(word) } else { parts.join(&format!("\"${{{variable}}}\"")) }
    };
    words.iter().map(word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::{command_line, quoted};

    #[test]
    fn shells_read_back_what_was_quoted() {
        for (text, written) in [
            ("/shots/leaf_01.ron", "/shots/leaf_01.ron"),
            ("a shot", "'a shot'"),
            ("", "''"),
            ("it's $HOME", r"'it'\''s $HOME'"),
            ("`x`;\"y\"", "'`x`;\"y\"'"),
        ] {
            assert_eq!(quoted(text), written);
        }
        let words = ["render", "--frames=\u{1}", "", "a b"].map(str::to_owned);
        assert_eq!(command_line(&words, '\u{1}', "frames"), "render --frames=\"${frames}\" '' 'a b'");
    }
}
