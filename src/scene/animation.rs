//! Animations of a glTF file. In go names and targets, out come those that play. Invariant: two animations
//! that play have different targets, unless all are requested.

use super::FrameRate;

/// An animation of a glTF file.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// The author's name, else `animation N`.
    pub name: String,
    /// Times of the first and last key, seconds; `None` without keys.
    pub keys_s: Option<(f64, f64)>,
    /// Names of its targets, each once: nodes, lights, cameras and materials.
    pub moves: Vec<String>,
    /// Whether it plays.
    pub is_played: bool,
}

impl Animation {
    /// Frames of the first and last key, which need not be integers.
    pub fn frames(&self, rate: FrameRate) -> Option<(f64, f64)> {
        // Keys are stored in single precision.
        let rounded = |frame: f64| if (frame - frame.round()).abs() <= 1e-4 { frame.round() } else { frame };
        self.keys_s.map(|(first_s, last_s)| (rounded(rate.frame(first_s)), rounded(rate.frame(last_s))))
    }
}
