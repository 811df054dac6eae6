//! Suggestions for unknown names: "did you mean". In go an unknown name and the known ones, out comes a
//! remedy. Invariant: a name that differs too much is not suggested.

/// Remedy for an unknown name, from the known ones.
pub(crate) fn remedy<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    // A missing unit is a likely slip, whatever its length.
    let lacks_unit = |name: &str| name.strip_prefix(unknown).is_some_and(|unit| unit.starts_with('_'));
    let distance = |name: &str| if lacks_unit(name) { 1 } else { strsim::damerau_levenshtein(unknown, name) };
    let nearest = known.into_iter().map(|name| (distance(name), name)).min_by_key(|(distance, _)| *distance);
    match nearest {
        // At most a third of the letters may differ; beyond that a guess misleads.
        Some((distance, name)) if distance * 3 <= name.chars().count().max(3) => {
            format!("did you mean `{name}`?")
        }
        _ => String::from("correct the name, or take it out"),
    }
}

/// List for a message: `a`, `b`, `c`.
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
