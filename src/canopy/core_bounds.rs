//! Bounds without outliers. In go boxes with weights, out comes the box around most of the weight. Invariant:
//! a small and distant box changes nothing, at any distance.

use glam::DVec3;

/// A box in world space.
pub(crate) type Bounds = (DVec3, DVec3);

/// A box with its weight: its area, m^2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weighed {
    pub(crate) bounds: Bounds,
    pub(crate) area_m2: f64,
}

/// Kind of outliers that are left out of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Strays {
    /// Sparse groups, which would make all cells larger for little area.
    Sparse,
    /// Distant groups, which exchange hardly any light with the rest.
    Lost,
}

impl Strays {
    /// Whether a group of an area is such an outlier. A gap separates it from the rest, which has a size and
    /// an area.
    fn are(self, (gap_m, area_m2): (f64, f64), (rest_m, rest_m2): (f64, f64)) -> bool {
        /// Gap relative to the rest's size, times the root of the group's relative area.
        const GAP: f64 = 4.0;
        /// Maximum area relative to the rest, and solid angle as seen from the rest.
        const LITTLE: f64 = 0.02;
        const SOLID_ANGLE: f64 = 1e-2;
        let share = area_m2 / rest_m2.max(f64::MIN_POSITIVE);
        match self {
            Self::Sparse => gap_m > GAP * rest_m * share.sqrt(),
            Self::Lost => share < LITTLE && gap_m > rest_m && area_m2 < SOLID_ANGLE * gap_m * gap_m,
        }
    }
}

pub(crate) fn union(a: Bounds, b: Bounds) -> Bounds {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Box around all but outliers, found from the ends of each axis inwards; `None` if there are no boxes.
pub(crate) fn core_bounds(mut all: Vec<Weighed>, strays: Strays) -> Option<Bounds> {
    /// Number of passes. Each removes the outermost groups on all sides, as outliers hide others.
    const PASSES: usize = 16;
    for _ in 0..PASSES {
        let before = all.len();
        for axis in 0..3 {
            for is_high in [false, true] {
                take_from_end(&mut all, (axis, is_high), strays);
            }
        }
        if all.len() == before {
            break;
        }
    }
    all.into_iter().map(|weighed| weighed.bounds).reduce(union)
}

/// Part of an axis: the lowest start and the highest end of the boxes that begin in it, and their area.
#[derive(Clone, Copy)]
struct Slab {
    begins: f64,
    ends: f64,
    area_m2: f64,
}

/// Removes boxes beyond the innermost gap that separates outliers from the rest.
fn take_from_end(all: &mut Vec<Weighed>, (axis, is_high): (usize, bool), strays: Strays) {
    /// Number of slabs; gaps within a slab are found once the axis is shorter.
    const SLABS: usize = 256;
    // From the end inwards: start and end of a box.
    let span = |weighed: &Weighed| {
        let (low, high) = (weighed.bounds.0[axis], weighed.bounds.1[axis]);
        if is_high { (-high, -low) } else { (low, high) }
    };
    let spans = all.iter().map(span);
    let (first, last) = spans.fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), (begins, ends)| {
        (first.min(begins), last.max(ends))
    });
    let mut slabs = [Slab { begins: f64::INFINITY, ends: f64::NEG_INFINITY, area_m2: 0.0 }; SLABS];
    for weighed in all.iter() {
        let (begins, ends) = span(weighed);
        let slab =
            &mut slabs[((begins - first) / (last - first) * SLABS as f64).min(SLABS as f64 - 1.0) as usize];
        slab.begins = slab.begins.min(begins);
        slab.ends = slab.ends.max(ends);
        slab.area_m2 += weighed.area_m2;
    }
    let whole: f64 = slabs.iter().map(|slab| slab.area_m2).sum();
    let (mut area, mut reached, mut rest_begins) = (0.0, f64::NEG_INFINITY, first);
    for slab in slabs.iter().filter(|slab| slab.begins.is_finite()) {
        if 2.0 * area > whole {
            break;
        }
        let rest = (last - slab.begins, whole - area);
        if slab.begins > reached && reached.is_finite() && strays.are((slab.begins - reached, area), rest) {
            rest_begins = slab.begins;
        }
        area += slab.area_m2;
        reached = reached.max(slab.ends);
    }
    all.retain(|weighed| span(weighed).0 >= rest_begins);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(middle: DVec3, side_m: f64) -> Weighed {
        Weighed { bounds: (middle - 0.5 * side_m, middle + 0.5 * side_m), area_m2: side_m * side_m }
    }

    fn heap(count: usize, about: DVec3) -> Vec<Weighed> {
        let place = |number: usize| {
            DVec3::new((number % 7) as f64, (number / 7 % 5) as f64, (number / 35) as f64) * 0.5
        };
        (0..count).map(|number| cube(about + place(number), 0.1)).collect()
    }

    #[test]
    fn strays_at_any_distance_and_any_number_of_sides_change_nothing() {
        let all = heap(200, DVec3::ZERO);
        let expected = core_bounds(all.clone(), Strays::Sparse).expect("there are some");
        for distance in [50.0, 1e3, 1e5] {
            let strays =
                [DVec3::X, -DVec3::Y, DVec3::new(1.0, 1.0, -1.0)].map(|away| cube(distance * away, 0.1));
            for kind in [Strays::Sparse, Strays::Lost] {
                let with = [all.clone(), strays.to_vec()].concat();
                assert_eq!(core_bounds(with, kind), Some(expected), "{distance} {kind:?}");
            }
        }
    }

    #[test]
    fn two_heaps_are_one_unless_they_are_far_apart() {
        let two = |distance: f64| [heap(200, DVec3::ZERO), heap(200, distance * DVec3::X)].concat();
        let longest = |all| core_bounds(all, Strays::Sparse).map(|(low, high)| (high - low).max_element());
        assert!(longest(two(8.0)).is_some_and(|longest| longest > 8.0));
        assert!(longest(two(1e3)).is_some_and(|longest| longest < 5.0));
        let lost = core_bounds(two(1e3), Strays::Lost).expect("there are some");
        assert!((lost.1 - lost.0).max_element() > 1e3);
    }

    #[test]
    fn what_is_alone_stays() {
        let one = [cube(DVec3::splat(3.0), 0.1)];
        assert_eq!(core_bounds(one.to_vec(), Strays::Lost), Some(one[0].bounds));
        assert_eq!(core_bounds(Vec::new(), Strays::Lost), None);
    }
}
