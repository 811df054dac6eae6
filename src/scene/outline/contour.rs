//! Contours of a grid of alphas at a threshold. In go alphas at texel centres, out come closed rings of
//! points in texels. Invariant: before simplification, rings cross neither themselves nor each other, and all
//! are closed, at the window's border if necessary.

use glam::DVec2;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Range of texels to examine; outside it alpha is 0.
#[derive(Clone, Debug)]
pub(super) struct Window {
    pub(super) columns: RangeInclusive<i64>,
    pub(super) rows: RangeInclusive<i64>,
}

impl Window {
    fn holds(&self, column: i64, row: i64) -> bool {
        self.columns.contains(&column) && self.rows.contains(&row)
    }
}

/// Maximum number of crossings between texels. Pictures of foliage have a tenth of that; each takes some 100
/// bytes.
const MOST_CROSSINGS: usize = 1 << 20;

/// Crossing of a contour between two neighbouring texels: the one with smaller indices, and whether the other
/// one is below it or to its right.
type Crossing = (i64, i64, bool);

/// Contours where alpha, bilinear between texel centres, is `threshold`. The centre of texel (0, 0) is at
/// (0.5, 0.5).
///
/// The method is marching squares. Where two opposite corners of a cell are inside, the value at the saddle
/// decides whether they are connected (Nielson and Hamann 1991, "The asymptotic decider"). `None` if there
/// are too many crossings, as in noise.
pub(super) fn rings(
    alpha: impl Fn(i64, i64) -> f64,
    threshold: f64,
    window: &Window,
) -> Option<Vec<Vec<DVec2>>> {
    let inside_by = |column: i64, row: i64| {
        if window.holds(column, row) { alpha(column, row) - threshold } else { f64::NEG_INFINITY }
    };
    let mut next = links(&inside_by, window)?;
    let place = |&(column, row, down): &Crossing| {
        let (step_x, step_y) = if down { (0, 1) } else { (1, 0) };
        let (a, b) = (inside_by(column, row), inside_by(column + step_x, row + step_y));
        DVec2::new(column as f64, row as f64)
            + 0.5
            + fraction(a, b) * DVec2::new(step_x as f64, step_y as f64)
    };
    let mut rings = Vec::new();
    while let Some((first, mut follower)) = next.pop_first() {
        let mut ring = vec![place(&first), follower.1];
        while let Some(then) = next.remove(&follower.0) {
            ring.extend([place(&follower.0), then.1]);
            follower = then;
        }
        rings.push(ring);
    }
    Some(rings)
}

/// Next crossing after each, and the midpoint between them.
type Links = BTreeMap<Crossing, (Crossing, DVec2)>;

/// Segments of the contours, cell by cell; `None` if there are too many.
fn links(inside_by: &impl Fn(i64, i64) -> f64, window: &Window) -> Option<Links> {
    let mut next = Links::new();
    for row in *window.rows.start() - 1..=*window.rows.end() {
        if next.len() > MOST_CROSSINGS {
            return None;
        }
        for column in *window.columns.start() - 1..=*window.columns.end() {
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| inside_by(column + x, row + y));
            link_cell(column, row, corners, &mut next);
        }
    }
    Some(next)
}

/// Adds the segments of one cell: none, one, or two at a saddle.
fn link_cell(column: i64, row: i64, corners: [f64; 4], next: &mut Links) {
    let is_inside = corners.map(|corner| corner >= 0.0);
    if is_inside == [true; 4] || is_inside == [false; 4] {
        return;
    }
    let edges =
        [(column, row, false), (column + 1, row, true), (column, row + 1, false), (column, row, true)];
    let cell = Cell { place: DVec2::new(column as f64, row as f64) + 0.5, corners };
    let [a, b, c, d] = corners;
    let joined = (a * c - b * d) / (a + c - b - d) >= 0.0;
    for corner in 0..4 {
        // The contour leaves the inside between this corner and the next ...
        let (before, after) = ((corner + 3) % 4, (corner + 1) % 4);
        if !is_inside[corner] || is_inside[after] {
            continue;
        }
        // ... and returns where the first outer corner follows an inner one.
        let is_saddle = is_inside[(corner + 2) % 4] && !is_inside[before];
        let back = match (is_saddle, joined) {
            (true, true) => after,
            (true, false) => before,
            _ => (1..4)
                .map(|step| (corner + step) % 4)
                .find(|&edge| !is_inside[edge] && is_inside[(edge + 1) % 4])
                .unwrap_or(before),
        };
        let middle = cell.on_curve(0.5 * (cell.crossing(corner) + cell.crossing(back)));
        next.insert(edges[corner], (edges[back], middle));
    }
}

/// Fraction at which linear interpolation between two values, one of them negative, is 0.
fn fraction(a: f64, b: f64) -> f64 {
    let fraction = a / (a - b);
    // Outside the window one value is infinite.
    if fraction.is_nan() || a.is_infinite() || b.is_infinite() { 0.5 } else { fraction }
}

/// Square between four texel centres.
struct Cell {
    place: DVec2,
    /// Values from the top left on, clockwise in the image.
    corners: [f64; 4],
}

impl Cell {
    /// Crossing between a corner and the next.
    fn crossing(&self, edge: usize) -> DVec2 {
        const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let (from, to) = (CORNERS[edge], CORNERS[(edge + 1) % 4]);
        self.place + from.lerp(to, fraction(self.corners[edge], self.corners[(edge + 1) % 4]))
    }

    /// Moves a point onto the contour, within the cell.
    fn on_curve(&self, near: DVec2) -> DVec2 {
        let [a, b, c, d] = self.corners;
        if !(a + b + c + d).is_finite() {
            return near;
        }
        let mut p = near - self.place;
        for _ in 0..2 {
            let value =
                a * (1.0 - p.x) * (1.0 - p.y) + b * p.x * (1.0 - p.y) + c * p.x * p.y + d * (1.0 - p.x) * p.y;
            let gradient =
                DVec2::new((b - a) * (1.0 - p.y) + (c - d) * p.y, (d - a) * (1.0 - p.x) + (c - b) * p.x);
            let step = value / gradient.length_squared() * gradient;
            if !step.is_finite() {
                break;
            }
            p = (p - step).clamp(DVec2::ZERO, DVec2::ONE);
        }
        self.place + p
    }
}

/// Maximum number of points between kept ones, as a ring that keeps every point would take quadratic time.
const LONGEST_STRETCH: usize = 512;

/// Ring with fewer points, within `tolerance` of all points of the old one (Ramer 1972, Douglas and Peucker
/// 1973); fewer than three points if it vanishes.
pub(super) fn simplified(ring: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let distance = |a: usize, b: usize| ring[a].distance_squared(ring[b]);
    let farthest =
        |from: usize| (0..ring.len()).max_by(|&a, &b| distance(from, a).total_cmp(&distance(from, b)));
    // Split at the longest distance, so that neither half has equal ends.
    let Some(start) = farthest(0) else { return Vec::new() };
    let opposite = farthest(start).map_or(0, |end| (end + ring.len() - start) % ring.len());
    let point = |index: usize| ring[(start + index) % ring.len()];
    let mut kept: Vec<usize> =
        (0..ring.len()).step_by(LONGEST_STRETCH).chain([opposite, ring.len()]).collect();
    kept.sort_unstable();
    let mut waiting: Vec<_> = kept.windows(2).map(|ends| (ends[0], ends[1])).collect();
    kept.pop(); // the start again
    while let Some((from, to)) = waiting.pop() {
        let worst = (from + 1..to)
            .map(|index| (index, distance_to_segment(point(index), point(from), point(to))))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, distance)) = worst.filter(|worst| worst.1 > tolerance) {
            debug_assert!(distance > 0.0);
            kept.push(index);
            waiting.extend([(from, index), (index, to)]);
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(point).collect()
}

fn distance_to_segment(point: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let t = ((point - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(a + t * along)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(ring: &[DVec2]) -> f64 {
        (0..ring.len()).map(|index| 0.5 * ring[index].perp_dot(ring[(index + 1) % ring.len()])).sum()
    }

    const WINDOW: Window = Window { columns: -2..=65, rows: -2..=65 };

    /// Alpha falls off linearly across the edge of a disc, as in an antialiased picture of it.
    fn disc(centre: DVec2, radius: f64) -> impl Fn(i64, i64) -> f64 {
        move |column, row| {
            let texel = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            (0.5 + radius - texel.distance(centre)).clamp(0.0, 1.0)
        }
    }

    #[test]
    fn a_long_ring_without_a_straight_stretch_loses_no_point() {
        let count = 1 << 18;
        let zigzag = (0..count).map(|i| DVec2::new(f64::from(i), f64::from(i % 2)));
        let ring: Vec<DVec2> = zigzag.chain([DVec2::new(f64::from(count), 1e6)]).collect();
        assert_eq!(simplified(&ring, 0.25).len(), ring.len());
    }

    #[test]
    fn a_disc_is_one_ring_of_its_size_and_place() {
        for (centre, radius) in [(DVec2::new(31.7, 32.2), 20.3), (DVec2::new(10.0, 50.5), 5.5)] {
            let rings = rings(disc(centre, radius), 0.5, &WINDOW).expect("few");
            assert_eq!(rings.len(), 1);
            let worst =
                rings[0].iter().map(|point| (point.distance(centre) - radius).abs()).fold(0.0, f64::max);
            // The texels themselves, clamped and joined by planes, are not quite the disc.
            assert!(worst < 0.1, "{worst}");
            let exact = std::f64::consts::PI * radius * radius;
            assert!((area(&rings[0]).abs() / exact - 1.0).abs() < 0.01);
            let simple = simplified(&rings[0], 0.25);
            assert!(simple.len() * 4 < rings[0].len(), "{}", simple.len());
            let edges = (0..simple.len()).map(|i| (simple[i], simple[(i + 1) % simple.len()]));
            let off = rings[0].iter().map(|&point| {
                edges.clone().map(|(a, b)| distance_to_segment(point, a, b)).fold(f64::INFINITY, f64::min)
            });
            assert!(off.fold(0.0, f64::max) <= 0.25);
        }
    }

    #[test]
    fn a_hole_is_a_ring_of_the_other_sense() {
        let centre = DVec2::splat(32.0);
        let (outer, inner) = (disc(centre, 25.0), disc(centre, 10.0));
        let rings = rings(|column, row| outer(column, row) - inner(column, row), 0.5, &WINDOW).expect("few");
        let areas: Vec<f64> = rings.iter().map(|ring| area(ring)).collect();
        assert_eq!(areas.len(), 2);
        assert!(areas[0] * areas[1] < 0.0, "{areas:?}");
        let expected = std::f64::consts::PI * (625.0 - 100.0);
        assert!((areas.iter().sum::<f64>().abs() / expected - 1.0).abs() < 0.01);
    }

    /// Two opposite texels: joined or apart as the value between the four says.
    #[test]
    fn saddles_are_decided_by_their_middle() {
        let checkers = |other: f64| {
            move |column: i64, row: i64| match (column, row) {
                (0, 0) | (1, 1) => 1.0,
                (0, 1) | (1, 0) => other,
                _ => 0.0,
            }
        };
        let window = Window { columns: -1..=2, rows: -1..=2 };
        let count = |threshold: f64| rings(checkers(0.1), threshold, &window).expect("few").len();
        assert_eq!(count(0.4), 1);
        assert_eq!(count(0.7), 2);
    }

    #[test]
    fn all_inside_is_closed_at_the_border() {
        let rings = rings(|_, _| 1.0, 0.5, &Window { columns: 0..=3, rows: 0..=1 }).expect("few");
        assert_eq!(rings.len(), 1);
        let mut sizes =
            rings[0].iter().fold((DVec2::MAX, DVec2::MIN), |(low, high), p| (low.min(*p), high.max(*p)));
        sizes.1 -= sizes.0;
        assert_eq!(sizes.1, DVec2::new(4.0, 2.0));
    }
}
