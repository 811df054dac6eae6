//! Meaning of RON text. In go a file's bytes, out come those without comments, and without blanks outside of
//! strings. Invariant: files have equal results if and only if they parse alike.

/// Bytes of a file without comments and blanks, whose hash identifies the scene of a frame. So a new comment
/// makes no frame stale.
pub(super) fn meant(text: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(text.len());
    let mut end = 0;
    for (at, token) in tokens(text) {
        if at > end && out.last().is_some_and(|&last| is_word(last)) && is_word(token[0]) {
            out.push(b' ');
        }
        out.extend_from_slice(token);
        end = at + token.len();
    }
    out
}

/// Strings and other significant bytes, with their offsets.
pub(super) fn tokens(text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let mut end = 0;
    std::iter::from_fn(move || {
        loop {
            let rest = text.get(end..).filter(|rest| !rest.is_empty())?;
            let (at, blank) = (end, blank(rest));
            if blank == 0 {
                end += token(rest).clamp(1, rest.len());
                return Some((at, &text[at..end]));
            }
            end += blank;
        }
    })
}

/// Length of a blank or comment at the start; 0 without one.
fn blank(text: &[u8]) -> usize {
    match text {
        [first, ..] if first.is_ascii_whitespace() => 1,
        [b'/', b'/', rest @ ..] => 2 + rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len()),
        [b'/', b'*', ..] => {
            let (mut at, mut depth) = (2, 1);
            while depth > 0 && at < text.len() {
                let step = match &text[at..] {
                    [b'/', b'*', ..] => Some(1),
                    [b'*', b'/', ..] => Some(-1),
                    _ => None,
                };
                depth += step.unwrap_or(0);
                at += if step.is_some() { 2 } else { 1 };
            }
            at
        }
        _ => 0,
    }
}

/// Length of a string at the start, of any kind; else 1.
fn token(text: &[u8]) -> usize {
    let hashes = |from: usize| text[from..].iter().take_while(|&&byte| byte == b'#').count();
    match text {
        [quote @ (b'"' | b'\''), rest @ ..] => {
            let mut is_escaped = false;
            let end = rest.iter().position(|byte| {
                let is_end = byte == quote && !is_escaped;
                is_escaped = *byte == b'\\' && !is_escaped;
                is_end
            });
            end.map_or(text.len(), |end| end + 2)
        }
        [b'r', b'"' | b'#', ..] if text.get(1 + hashes(1)) == Some(&b'"') => {
            let closing = [&b"\""[..], &b"#".repeat(hashes(1))].concat();
            let start = 2 + hashes(1);
            let end = text[start..].windows(closing.len()).position(|window| window == closing);
            end.map_or(text.len(), |end| start + end + closing.len())
        }
        _ => 1,
    }
}

/// Whether a byte is part of a name or number.
pub(super) fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'.' | b'+' | b'-') || !byte.is_ascii()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn said(text: &str) -> String {
        String::from_utf8(meant(text.as_bytes())).unwrap()
    }

    #[test]
    fn comments_and_blanks_mean_nothing() {
        let plain = r###"Scene(version:1,name:"a // b /* c */",raw:r##"d "# // e"##,c:'"')"###;
        assert_eq!(said(plain), plain);
        let commented = "// first\nScene ( /* in /* deeply */ side */ version : 1 , name: \"a // b /* c */\",\n\
            raw: r##\"d \"# // e\"##, // last\n c: '\"' )\n";
        assert_eq!(said(commented), plain);
    }

    #[test]
    fn what_reads_differently_stays_different() {
        for (one, other) in
            [("(a: \"b c\")", "(a: \"bc\")"), ("(a: 12)", "(a: 1 2)"), (r#"("\" //")"#, r#"("\"")"#)]
        {
            assert_ne!(said(one), said(other));
        }
    }

    /// Blanks and comments, with what means something elsewhere.
    const GAPS: [&str; 11] = [
        "",
        " ",
        "\t\n",
        "\r\n",
        "/**/",
        "/* \" ' r#\" */",
        "/* a /* b // */ c */",
        "// \" /* (\n",
        "//\r\n",
        "/*/**/*/",
        "\u{2028}",
    ];
    /// Values of one token.
    const WORDS: [&str; 20] = [
        "true",
        "-12",
        "0x1F",
        "1_000",
        "1e-3",
        "-.5",
        "+2.25",
        "'a'",
        "'\"'",
        "'\\''",
        "'/'",
        "\"\"",
        "\"a b\"",
        "\"// /* \\\" */\"",
        "\"\\\\\"",
        "r\"\\\"",
        "r#\"a\"b // \"#",
        "r##\"\"# /* \"##",
        "\"\u{e9} \u{2028}\"",
        "b\"x // \\\" y\"",
    ];

    /// The tokens of some value that RON reads, up to so deep.
    fn push_value(pick: &mut impl FnMut(usize) -> usize, depth: usize, tokens: &mut Vec<String>) {
        let kind = if depth == 0 { 0 } else { pick(5) };
        let [open, close] = [["", ""], ["[", "]"], ["(", ")"], ["{", "}"], ["Leaf(", ")"]][kind];
        if kind == 0 {
            tokens.push(String::from(WORDS[pick(WORDS.len())]));
            return;
        }
        tokens.extend(open.split_inclusive("Leaf").map(String::from));
        // Where any value may stand, RON tells `()` from `( )`; a struct without fields is either.
        let least = usize::from(kind == 2 || kind == 4);
        for number in 0..least + pick(4 - least) {
            match kind {
                3 => tokens.extend([format!("\"key // {number}\""), String::from(":")]),
                4 => tokens.extend([format!("r_{number}"), String::from(":")]),
                _ => {}
            }
            push_value(pick, depth - 1, tokens);
            tokens.push(String::from(","));
        }
        tokens.push(String::from(close));
    }

    proptest! {
        /// RON reads the same from the rest as from the whole.
        #[test]
        fn what_is_read_stays(seed in any::<u32>()) {
            let (chance, mut draw) = (crate::math::Chance::of(seed, 0), 0);
            let mut pick = |count: usize| {
                draw += 1;
                (chance.at(draw) * count as f64) as usize
            };
            let mut tokens = Vec::new();
            push_value(&mut pick, 4, &mut tokens);
            let mut whole = String::new();
            for token in &tokens {
                whole.push_str(token);
                // Commas and brackets part all words.
                whole.push_str(GAPS[pick(GAPS.len())]);
            }
            let read = |text: &str| ::ron::from_str::<::ron::Value>(text);
            let expected = read(&whole);
            prop_assert!(expected.is_ok(), "{whole}: {expected:?}");
            let left = said(&whole);
            prop_assert_eq!(read(&left), expected, "{} of {}", left, whole);
            prop_assert_eq!(left.replace('\u{2028}', ""), said(&tokens.concat()).replace('\u{2028}', ""));
        }

        #[test]
        fn any_bytes_are_taken(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let once = meant(&bytes);
            prop_assert!(once.len() <= bytes.len());
        }
    }
}
