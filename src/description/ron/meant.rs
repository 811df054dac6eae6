//! What RON text means. In go a file's bytes, out come those without comments, and without blanks that
//! stand outside of texts. Invariant: files that read alike are alike then, and others are not.

/// Its bytes, of which frames know their scene: a comment more makes none of them stale.
pub(super) fn meant(text: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(text.len());
    let (mut rest, mut has_gap) = (text, false);
    while let Some(&first) = rest.first() {
        let length = blank(rest);
        if length > 0 {
            has_gap = true;
            rest = &rest[length..];
            continue;
        }
        if has_gap && out.last().is_some_and(|&last| is_word(last)) && is_word(first) {
            out.push(b' ');
        }
        has_gap = false;
        let (token, others) = rest.split_at(token(rest).clamp(1, rest.len()));
        out.extend_from_slice(token);
        rest = others;
    }
    out
}

/// How long a blank or a comment at the start is; 0 if neither is there.
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

/// How long a text at the start is, in quotes of any kind; else a byte.
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

fn is_word(byte: u8) -> bool {
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

    proptest! {
        #[test]
        fn any_bytes_are_taken(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let once = meant(&bytes);
            prop_assert!(once.len() <= bytes.len());
        }
    }
}
