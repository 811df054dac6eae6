//! Choice of the picture among a file's parts and channels, by their names. In go names, out come indices.
//! Invariant: the order of parts and channels only decides between equal names.

/// Channels of a picture, by their indices in the list of names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picture {
    /// Red, green and blue.
    Colors([usize; 3]),
    /// Luminance alone.
    Luminance(usize),
    /// Luminance and chroma: `Y`, `RY` and `BY`.
    Chroma([usize; 3]),
}

const COLORS: [[&str; 3]; 3] = [["R", "G", "B"], ["r", "g", "b"], ["red", "green", "blue"]];

/// Names of layers and parts that hold the picture itself, the likeliest first.
const PICTURES: [&str; 11] =
    ["", "rgba", "rgb", "beauty", "combined", "composite", "color", "colour", "ci", "c", "main"];

/// Names, and endings of names, of channels without light.
const NO_LIGHT: [&str; 24] = [
    "n",
    "nn",
    "ng",
    "ns",
    "hitn",
    "normal",
    "normals",
    "tangent",
    "tangents",
    "p",
    "po",
    "pw",
    "pref",
    "hitp",
    "pworld",
    "position",
    "st",
    "uv",
    "uvs",
    "vector",
    "motion",
    "motionvector",
    "velocity",
    "depth",
];

impl Picture {
    /// Picture of a part, or of a whole file, with channels of these names.
    pub fn among<S: AsRef<str>>(names: &[S]) -> Option<Self> {
        let place = |wanted: &str| names.iter().position(|name| name.as_ref() == wanted);
        let mut found: Vec<(usize, [usize; 3])> = Vec::new();
        for name in names {
            let layer = name.as_ref().rfind('.').map_or("", |dot| &name.as_ref()[..=dot]);
            if !is_light(layer.trim_end_matches('.')) {
                continue;
            }
            for colors in COLORS {
                let [red, green, blue] = colors.map(|color| place(&format!("{layer}{color}")));
                if let (Some(red), Some(green), Some(blue)) = (red, green, blue) {
                    found.push((rank(layer.trim_end_matches('.')), [red, green, blue]));
                }
            }
        }
        // The first one among equal ranks.
        if let Some((_, colors)) = found.into_iter().min_by_key(|(rank, _)| *rank) {
            return Some(Self::Colors(colors));
        }
        // A single colour channel is shown as grey.
        let own: Vec<usize> = COLORS[0].iter().filter_map(|color| place(color)).collect();
        let lone = || if let [only] = own[..] { Some(only) } else { None };
        let luminance = place("Y").or_else(lone)?;
        Some(match (place("RY"), place("BY")) {
            (Some(red), Some(blue)) => Self::Chroma([luminance, red, blue]),
            _ => Self::Luminance(luminance),
        })
    }
}

/// Channels shown as red, green and blue for a file without a picture: those of these names, in the layer
/// with most of them; else a single channel as grey, alpha last.
pub fn stand_in<S: AsRef<str>>(names: &[S]) -> [Option<usize>; 3] {
    let place = |wanted: &str| names.iter().position(|name| name.as_ref() == wanted);
    let layers = names.iter().map(|name| name.as_ref().rfind('.').map_or("", |dot| &name.as_ref()[..=dot]));
    let colors = layers.map(|layer| COLORS[0].map(|color| place(&format!("{layer}{color}"))));
    // The first one among equal layers.
    match colors.min_by_key(|colors| colors.iter().filter(|color| color.is_none()).count()) {
        Some(colors) if colors.iter().flatten().count() > 1 => colors,
        _ => {
            let is_coverage = |name: &S| name.as_ref() == "A" || name.as_ref().ends_with(".A");
            let grey = names.iter().position(|name| !is_coverage(name));
            [grey.or((!names.is_empty()).then_some(0)); 3]
        }
    }
}

/// Rank of a layer or part by its name; the picture has the smallest.
fn rank(name: &str) -> usize {
    let own = own(name);
    PICTURES.iter().position(|picture| *picture == own).unwrap_or(PICTURES.len())
}

/// Last word of a name such as `view.diffuse`, in lower case.
fn own(name: &str) -> String {
    name.rsplit('.').next().unwrap_or(name).to_lowercase()
}

/// Whether a channel holds light; false for normals, positions, motion, depths and ids.
fn is_light(name: &str) -> bool {
    let own = own(name).replace([' ', '-'], "_");
    let is_id = own == "id" || own.ends_with("_id") || own.starts_with("crypto");
    let is_other = NO_LIGHT
        .iter()
        .any(|other| own == *other || own.strip_suffix(other).is_some_and(|rest| rest.ends_with('_')));
    !is_id && !is_other
}

/// Index of the part with the picture, from the names of parts and of their channels.
pub fn part_of_picture(parts: &[(String, Vec<String>)]) -> usize {
    let holds =
        |(name, channels): &&(String, Vec<String>)| is_light(name) && Picture::among(channels).is_some();
    let places = parts.iter().enumerate().filter(|(_, part)| holds(part));
    places.min_by_key(|(_, (name, _))| rank(name)).map_or(0, |(place, _)| place)
}

/// Unique names for the channels of all parts: plain in the picture's part, with the part's name as a prefix
/// in others.
pub fn full_names(parts: &[(String, Vec<String>)]) -> Vec<Vec<String>> {
    let plain = part_of_picture(parts);
    let mut taken = std::collections::HashSet::new();
    let mut named = vec![Vec::new(); parts.len()];
    // The picture's part first, so that its names stay plain.
    let order = std::iter::once(plain).chain((0..parts.len()).filter(|&part| part != plain));
    for part in order {
        let (name, channels) = &parts[part];
        for channel in channels {
            let is_whole = part == plain || channel.starts_with(&format!("{name}."));
            let full = if is_whole { channel.clone() } else { format!("{name}.{channel}") };
            let full = if taken.contains(&full) { format!("part {}.{channel}", part + 1) } else { full };
            taken.insert(full.clone());
            named[part].push(full);
        }
    }
    named
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn part(name: &str, channels: &[&str]) -> (String, Vec<String>) {
        (name.to_owned(), channels.iter().map(|&channel| channel.to_owned()).collect())
    }

    #[test]
    fn the_picture_is_the_beauty_whatever_the_order() {
        for (names, expected) in [
            (&["A", "B", "G", "R"][..], Some(Picture::Colors([3, 2, 1]))),
            (&["N.R", "N.G", "N.B", "diffuse.R", "diffuse.G", "diffuse.B"], Some(Picture::Colors([3, 4, 5]))),
            (
                &["d.R", "d.G", "d.B", "view.Combined.R", "view.Combined.G", "view.Combined.B"],
                Some(Picture::Colors([3, 4, 5])),
            ),
            (&["BY", "RY", "Y"], Some(Picture::Chroma([2, 1, 0]))),
            (&["A", "Y"], Some(Picture::Luminance(1))),
            (&["A", "G"], Some(Picture::Luminance(1))),
            (&["A", "G", "R"], None),
            (&["Z"], None),
        ] {
            assert_eq!(Picture::among(names), expected, "{names:?}");
        }
    }

    #[test]
    fn channels_stand_in_for_a_picture() {
        for (names, expected) in [
            (&["A", "Z"][..], [Some(1); 3]),
            (&["A"], [Some(0); 3]),
            (&["G", "R"], [Some(1), Some(0), None]),
            (&["A", "N.B", "N.G", "N.R", "P.G", "P.R"], [Some(3), Some(2), Some(1)]),
            (&["depth.R", "depth.Z"], [Some(0); 3]),
            (&[], [None; 3]),
        ] {
            assert_eq!(stand_in(names), expected, "{names:?}");
        }
    }

    #[test]
    fn parts_lend_their_names() {
        let colors = ["R", "G", "B"];
        let parts =
            [part("N", &colors), part("albedo", &colors), part("C", &colors), part("C", &["R", "C.Z"])];
        assert_eq!(part_of_picture(&parts), 2);
        let named = full_names(&parts);
        assert_eq!(named[0], ["N.R", "N.G", "N.B"]);
        assert_eq!(named[2], colors);
        assert_eq!(named[3], ["C.R", "C.Z"]);
        assert_eq!(
            full_names(&[part("left", &["R"]), part("left", &["R"]), part("left", &["R"])])[2],
            ["part 3.R"]
        );
    }
}
