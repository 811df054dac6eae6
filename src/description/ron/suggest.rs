//! "Did you mean": the known name nearest to an unknown one.

/// Remedy for an unknown name, given those that there are.
pub(crate) fn remedy<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    // A name without its unit is a slip however long that is.
    let lacks_unit = |name: &str| name.strip_prefix(unknown).is_some_and(|unit| unit.starts_with('_'));
    let distance = |name: &str| if lacks_unit(name) { 1 } else { strsim::damerau_levenshtein(unknown, name) };
    let nearest = known.into_iter().map(|name| (distance(name), name)).min_by_key(|(distance, _)| *distance);
    match nearest {
        // A third of the letters may be wrong; beyond that a guess misleads.
        Some((distance, name)) if distance * 3 <= name.chars().count().max(3) => {
            format!("did you mean `{name}`?")
        }
        _ => String::from("correct the name, or take it out"),
    }
}

/// `a`, `b`, `c`, for a message.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_finger_is_recognised_and_a_different_word_is_not() {
        assert_eq!(remedy("brich", ["oak", "birch"]), "did you mean `birch`?");
        assert_eq!(remedy("curl", ["coil", "curl_deg"]), "did you mean `curl_deg`?");
        assert_eq!(remedy("walnut", ["oak", "birch"]), "correct the name, or take it out");
    }
}
