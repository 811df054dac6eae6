//! The animations of a glTF file, by name. Invariant: one that is played moves what no other one that is
//! played does, unless whoever renders asked for all of them.

use super::FrameRate;

/// An animation of a glTF file.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// The author's name, else `animation N`.
    pub name: String,
    /// Times of its first and its last key, seconds; `None` if it has no keys.
    pub keys_s: Option<(f64, f64)>,
    /// Names of the nodes, lights, cameras and materials that it moves, each once.
    pub moves: Vec<String>,
    /// Whether it takes part in the picture.
    pub is_played: bool,
}

impl Animation {
    /// The frames of its first and its last key, which may lie between whole frames.
    pub fn frames(&self, rate: FrameRate) -> Option<(f64, f64)> {
        // Keys are in single precision.
        let rounded = |frame: f64| if (frame - frame.round()).abs() <= 1e-4 { frame.round() } else { frame };
        self.keys_s.map(|(first_s, last_s)| (rounded(rate.frame(first_s)), rounded(rate.frame(last_s))))
    }
}
