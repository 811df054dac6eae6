//! Layout of a picture's slices. In go facts about its light, lens, shutter and samples, out comes one of
//! four layouts. Invariant: the choice is the whole picture's, whichever part of it is wanted.
//!
//! A *draw* is a moment of the shutter, a point of the lens and a point of the light (`draws.rs`).

/// Draws of the slices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// All have the same: there is nothing to draw.
    Common,
    /// Each has its own, but their fans differ so little that slices keep their places between one another.
    InRings,
    /// Slices a pixel apart draw from the same stratum of light and lens, so that each pixel has seen all
    /// strata, and each at points of its own.
    InStrata,
    /// Each has its own, and knows nothing of its neighbours.
    OwnDraws,
}

/// Facts that decide about the layout.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    /// Whether light, lens or shutter have an extent.
    pub(super) is_drawn: bool,
    /// Whether slices mostly keep their places in the rings that the picture is cut in.
    pub(super) are_ordered: bool,
    /// Number of rings.
    pub(super) rings: u32,
    /// Whether draws differ in time: a few strata would show a moving thing as so many copies.
    pub(super) in_time: bool,
    /// Whether points of the light are not all as bright as each other: those of a lamp
    /// lie nearer or farther.
    pub(super) in_brightness: bool,
    /// Samples a pixel when all rounds are done.
    pub(super) samples: u32,
}

/// Maximum number of samples a pixel for draws in strata. Beyond it most of the error would be the blur of
/// swaths of a pixel's width.
const STRATA_TO: u32 = 128;

impl Layout {
    /// The one for a picture. Figures of the alternatives: docs/decisions/slices.md#layouts.
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

    /// As a still sun's disc before a lens that deviates far.
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
