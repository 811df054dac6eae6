//! Layout of a picture's slices. In go facts about its light, lens, shutter and samples, out comes one of
//! four layouts. Invariant: the choice is that of the whole picture, for any wanted part.
//!
//! A *draw* is a moment of the shutter, a point of the lens and a point of the light (`draws.rs`).

/// Draws of the slices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// All slices have the same draw: light, lens and shutter have no extent.
    Common,
    /// Each slice has its own draw; fans differ so little that slices keep their order.
    InRings,
    /// Slices a pixel apart draw from the same stratum of light and lens. So each pixel has all strata, and
    /// points of its own in each.
    InStrata,
    /// Each slice has its own draw, independent of its neighbours.
    OwnDraws,
}

/// Facts that decide on the layout.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    /// Whether light, lens or shutter have an extent.
    pub(super) is_drawn: bool,
    /// Whether slices mostly keep their order in the rings of the picture.
    pub(super) are_ordered: bool,
    /// Number of rings.
    pub(super) rings: u32,
    /// Whether draws differ in time: with few strata a moving object would show as that many copies.
    pub(super) in_time: bool,
    /// Whether points of the light differ in brightness, as those of a lamp do by their distances.
    pub(super) in_brightness: bool,
    /// Samples a pixel after all rounds.
    pub(super) samples: u32,
}

/// Maximum number of samples a pixel for draws in strata. Beyond it the blur of swaths a pixel wide would be
/// most of the error.
const STRATA_TO: u32 = 128;

impl Layout {
    /// Returns the layout of a picture. Figures of the alternatives: docs/decisions/slices.md#layouts.
    pub(super) fn choose(facts: &Facts) -> Self {
        let Facts { is_drawn, are_ordered, rings, in_time, in_brightness, samples } = *facts;
        if !is_drawn {
            Self::Common
        } else if are_ordered {
            Self::InRings
        } else if rings == 1 && !(in_time || in_brightness) && samples <= STRATA_TO {
            Self::InStrata
        } else {
            Self::OwnDraws
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A still sun's disc seen through a lens that deviates far.
    const DRAWN: Facts = Facts {
        is_drawn: true,
        are_ordered: false,
        rings: 1,
        in_time: false,
        in_brightness: false,
        samples: 32,
    };

    #[test]
    fn nothing_to_draw_is_common() {
        let facts = Facts { is_drawn: false, are_ordered: true, ..DRAWN };
        assert_eq!(Layout::choose(&facts), Layout::Common);
    }

    #[test]
    fn what_keeps_its_order_is_in_rings_whatever_moves() {
        for (rings, in_time) in [(1, false), (8, true)] {
            let facts = Facts { are_ordered: true, rings, in_time, ..DRAWN };
            assert_eq!(Layout::choose(&facts), Layout::InRings);
        }
    }

    #[test]
    fn suns_that_deviate_far_are_in_strata_unless_samples_are_many() {
        for (samples, layout) in [(1, Layout::InStrata), (128, Layout::InStrata), (256, Layout::OwnDraws)] {
            assert_eq!(Layout::choose(&Facts { samples, ..DRAWN }), layout, "{samples}");
        }
    }

    #[test]
    fn lamps_open_shutters_and_rings_have_draws_of_their_own() {
        for facts in [
            Facts { in_time: true, ..DRAWN },
            Facts { in_brightness: true, ..DRAWN },
            Facts { rings: 4, ..DRAWN },
        ] {
            assert_eq!(Layout::choose(&facts), Layout::OwnDraws);
        }
    }
}
