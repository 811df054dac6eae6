//! Segments between the first ray of a sweep that may meet them and the one that passes them. In go segments
//! and falling slopes, out come those that a ray meets or has passed. Invariant: they stay in order, and each
//! is passed once.

use super::segment::Segment;

/// Segments as arrays of their fields, as each ray reads one field of all of them: in a crown there are
/// hundreds.
#[derive(Debug, Default)]
pub(super) struct Active {
    segments: Vec<Segment>,
    /// Slopes of the upper and the lower end of each segment; NaN once it is passed.
    slopes: Vec<[f64; 2]>,
    passed: usize,
    /// The greatest slope of a ray that passes any more of them.
    next_pass: f64,
}

impl Active {
    pub(super) fn clear(&mut self) {
        self.segments.clear();
        self.slopes.clear();
        self.passed = 0;
        self.next_pass = f64::NEG_INFINITY;
    }

    /// Adds segments at the end.
    pub(super) fn extend(&mut self, segments: impl Iterator<Item = Segment>) {
        if 2 * self.passed > self.segments.len() {
            self.forget_passed();
        }
        self.segments.extend(segments);
        let new = &self.segments[self.slopes.len()..];
        let Self { next_pass, .. } = self;
        self.slopes.extend(new.iter().map(|segment| {
            *next_pass = next_pass.max(segment.lower.slope);
            [segment.upper.slope, segment.lower.slope]
        }));
    }

    fn forget_passed(&mut self) {
        let mut slopes = self.slopes.iter();
        self.segments.retain(|_| slopes.next().is_some_and(|[_, lower]| !lower.is_nan()));
        self.slopes.retain(|[_, lower]| !lower.is_nan());
        self.passed = 0;
    }

    /// Number of segments that are not passed.
    pub(super) fn count(&self) -> usize {
        self.segments.len() - self.passed
    }

    /// Segments that are not passed.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Segment> {
        self.segments
            .iter()
            .zip(&self.slopes)
            .filter(|(_, [_, lower])| !lower.is_nan())
            .map(|(segment, _)| segment)
    }

    pub(super) fn segment(&self, number: usize) -> &Segment {
        &self.segments[number]
    }

    /// Numbers of the segments that rays of a slope meet. An end on a ray counts as above it, for all
    /// segments alike.
    pub(super) fn met_at(&self, slope: f64) -> impl Iterator<Item = usize> {
        let is_met = move |[upper, lower]: &[f64; 2]| slope <= *upper && *lower < slope;
        self.slopes.iter().enumerate().filter(move |(_, slopes)| is_met(slopes)).map(|(number, _)| number)
    }

    /// Passes the segments that lie wholly above rays of a slope, one after another.
    pub(super) fn pass(&mut self, slope: f64, mut passed: impl FnMut(&Segment)) {
        if slope > self.next_pass {
            return;
        }
        self.next_pass = f64::NEG_INFINITY;
        for (segment, slopes) in self.segments.iter().zip(&mut self.slopes) {
            if slope <= slopes[1] {
                passed(segment);
                *slopes = [f64::NAN; 2];
                self.passed += 1;
            } else {
                self.next_pass = self.next_pass.max(slopes[1]);
            }
        }
    }
}
