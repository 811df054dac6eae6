//! A plot with logarithmic axes, as SVG. In go series of points, out comes the text of a file. Invariant:
//! series differ by label, marker and colour, never by colour alone.

use std::fmt::Write;

/// Picture size and the margins of the axes, pixels.
const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 560.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 30.0;
const TOP: f64 = 72.0;
const BOTTOM: f64 = 62.0;

/// Labels: height, width of a letter, distance from their point, and the space on the right for them.
const LINE_HEIGHT: f64 = 16.0;
const LETTER_WIDTH: f64 = 7.3;
const LABEL_GAP: f64 = 11.0;
const LABEL_ROOM: f64 = 110.0;

/// Margin by which the distance of labels may round down.
const ROUNDING: f64 = 0.01;

/// Colours that colour-blind people can distinguish (Okabe & Ito 2008), darkened for text on white.
const COLORS: [&str; 8] =
    ["#d55e00", "#0072b2", "#00815d", "#b07a00", "#b0508a", "#000000", "#6b6b6b", "#3d8fc4"];

/// Style of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Markers joined by a line; the number selects colour and marker.
    Line(usize),
    /// A line with markers, thin and dashed: not measured here.
    Dashed(usize),
    /// Markers alone, hollow: an estimate.
    Hollow(usize),
    /// A thin line alone: a fit to points.
    Fit,
}

/// Points of one method or renderer.
#[derive(Clone, Debug)]
pub struct Series {
    /// Label.
    pub name: String,
    /// Style.
    pub style: Style,
    /// Points in order of x, both positive.
    pub points: Vec<(f64, f64)>,
    /// Points of the same series off its line, drawn faint.
    pub aside: Vec<(f64, f64)>,
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Heading.
    pub title: String,
    /// Second heading, in smaller type below.
    pub subtitle: String,
    /// Label of the horizontal axis, with its unit.
    pub x_label: String,
    /// Label of the vertical axis, with its unit.
    pub y_label: String,
    /// The points.
    pub series: Vec<Series>,
}

struct Axis {
    low: f64,
    high: f64,
    from_px: f64,
    to_px: f64,
}

impl Axis {
    /// Axis from slightly below the smallest value to slightly above the largest, at least a decade.
    fn around(values: impl Iterator<Item = f64>, from_px: f64, to_px: f64) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value.log10()), high.max(value.log10()))
        });
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let spare = 0.06 * (high - low) + (0.5 - 0.5 * (high - low)).max(0.05);
        Self { low: low - spare, high: high + spare, from_px, to_px }
    }

    /// Scale extended to another pixel.
    fn reaching(self, to_px: f64) -> Self {
        let per_px = (self.high - self.low) / (self.to_px - self.from_px);
        Self { high: self.high + per_px * (to_px - self.to_px), to_px, ..self }
    }

    fn px(&self, value: f64) -> f64 {
        self.from_px + (value.log10() - self.low) / (self.high - self.low) * (self.to_px - self.from_px)
    }

    /// Values of grid lines, and whether each has a number. On a short axis 2 and 5 have one, too.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let decades = self.low.floor() as i32..=self.high.floor() as i32;
        let short = self.high - self.low < 2.2;
        let all = decades.flat_map(|decade| (1..10).map(move |digit| (digit, decade)));
        all.map(|(digit, decade)| {
            // Parsed rather than multiplied, so that 0.2 is exact.
            let value: f64 = format!("{digit}e{decade}").parse().unwrap_or(f64::NAN);
            (value, digit == 1 || short && [2, 5].contains(&digit))
        })
        .filter(|&(value, _)| (self.low..=self.high).contains(&value.log10()))
        .collect()
    }
}

impl Plot {
    /// The plot as an SVG file.
    pub fn to_svg(&self) -> String {
        let values =
            || self.series.iter().flat_map(|series| series.points.iter().chain(&series.aside)).copied();
        let x = Axis::around(values().map(|point| point.0), LEFT, WIDTH - RIGHT - LABEL_ROOM)
            .reaching(WIDTH - RIGHT);
        let y = Axis::around(values().map(|point| point.1), HEIGHT - BOTTOM, TOP);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
             height=\"{HEIGHT}\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" font-size=\"13\">\n\
             <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n"
        );
        let heading = [(30.0, 18, "#111111", &self.title), (51.0, 13, "#555555", &self.subtitle)];
        for (at, size, color, text) in heading {
            let weight = if size > 13 { "bold" } else { "normal" };
            let text = escaped(text);
            let _ = writeln!(
                svg,
                r#"<text x="{LEFT}" y="{at}" font-size="{size}" font-weight="{weight}" fill="{color}">{text}</text>"#
            );
        }
        self.draw_axes(&mut svg, &x, &y);
        for series in &self.series {
            draw_series(&mut svg, series, &x, &y);
        }
        self.draw_labels(&mut svg, &x, &y);
        svg.push_str("</svg>\n");
        svg
    }

    fn draw_axes(&self, svg: &mut String, x: &Axis, y: &Axis) {
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        let across = x.ticks().into_iter().map(|(value, labelled)| {
            let (at, below) = (x.px(value), bottom + 20.0);
            let place = format!(r#"x="{at:.1}" y="{below}" text-anchor="middle""#);
            (value, labelled, format!("M{at:.1} {TOP}V{bottom}"), place)
        });
        let up = y.ticks().into_iter().map(|(value, labelled)| {
            let (at, left) = (y.px(value), LEFT - 8.0);
            let place = format!(r#"x="{left}" y="{:.1}" text-anchor="end""#, at + 4.5);
            (value, labelled, format!("M{LEFT} {at:.1}H{right}"), place)
        });
        for (value, labelled, line, place) in across.chain(up) {
            let color = if labelled { "#d4d4d4" } else { "#f0f0f0" };
            let _ = writeln!(svg, r#"<path d="{line}" stroke="{color}" fill="none"/>"#);
            if labelled {
                let _ = writeln!(svg, r##"<text {place} fill="#333333">{}</text>"##, number(value));
            }
        }
        let _ = writeln!(
            svg,
            r##"<path d="M{LEFT} {TOP}V{bottom}H{right}" stroke="#333333" stroke-width="1.2" fill="none"/>"##
        );
        let (middle, below) = (0.5 * (LEFT + right), HEIGHT - 16.0);
        let (x_label, y_label) = (escaped(&self.x_label), escaped(&self.y_label));
        let _ = writeln!(
            svg,
            r##"<text x="{middle}" y="{below}" text-anchor="middle" fill="#333333">{x_label}</text>"##
        );
        let middle = 0.5 * (TOP + bottom);
        let _ = writeln!(
            svg,
            r##"<text transform="translate(20 {middle}) rotate(-90)" text-anchor="middle" fill="#333333">{y_label}</text>"##
        );
    }

    /// Draws a label at the end of each series, on its right where there is space; moved down where it would
    /// cover another.
    fn draw_labels(&self, svg: &mut String, x: &Axis, y: &Axis) {
        let mut labels: Vec<Label> = self
            .series
            .iter()
            .filter_map(|series| {
                let &(last_x, last_y) = series.points.last()?;
                let width = LETTER_WIDTH * series.name.chars().count() as f64;
                let (at, base) = (x.px(last_x), y.px(last_y) + 4.5);
                let fits = at + LABEL_GAP + width < WIDTH - 4.0;
                let left = if fits { at + LABEL_GAP } else { at - LABEL_GAP - width };
                Some(Label { left, base, width, ends_there: !fits, series })
            })
            .collect();
        labels.sort_by(|a, b| a.base.total_cmp(&b.base));
        for index in 0..labels.len() {
            while let Some(other) = labels[..index].iter().find(|other| labels[index].covers(other)) {
                labels[index].base = other.base + LINE_HEIGHT;
            }
            let Label { left, base, width, ends_there, series } = &labels[index];
            let (anchor, at) = if *ends_there { ("end", left + width) } else { ("start", *left) };
            let (name, (color, _)) = (escaped(&series.name), series.style.look());
            let place = format!(r#"x="{at:.1}" y="{base:.1}" text-anchor="{anchor}" font-weight="bold""#);
            // A white outline keeps it legible on lines.
            let _ = writeln!(
                svg,
                r##"<text {place} stroke="#ffffff" stroke-width="4" stroke-linejoin="round">{name}</text>"##
            );
            let _ = writeln!(svg, r#"<text {place} fill="{color}">{name}</text>"#);
        }
    }
}

/// Label of a series, with its position.
struct Label<'a> {
    left: f64,
    base: f64,
    width: f64,
    /// Whether it is to the left of its point.
    ends_there: bool,
    series: &'a Series,
}

impl Label<'_> {
    fn covers(&self, other: &Self) -> bool {
        let across = self.left < other.left + other.width && other.left < self.left + self.width;
        across && (self.base - other.base).abs() < LINE_HEIGHT - ROUNDING
    }
}

impl Style {
    /// Colour and marker.
    fn look(self) -> (&'static str, usize) {
        match self {
            Self::Line(number) | Self::Dashed(number) | Self::Hollow(number) => {
                (COLORS[number % COLORS.len()], number)
            }
            Self::Fit => ("#6b6b6b", 0),
        }
    }
}

fn draw_series(svg: &mut String, series: &Series, x: &Axis, y: &Axis) {
    let (color, kind) = series.style.look();
    let place = |&(a, b): &(f64, f64)| (x.px(a), y.px(b));
    for point in &series.aside {
        let _ = writeln!(svg, r#"<g opacity="0.28">{}</g>"#, marker(kind, place(point), color, color));
    }
    let line = match series.style {
        Style::Line(_) => Some(r#"stroke-width="2.4""#),
        Style::Dashed(_) => Some(r#"stroke-width="1.6" stroke-dasharray="5 4""#),
        Style::Fit => Some(r#"stroke-width="1.6" stroke-dasharray="2 3""#),
        Style::Hollow(_) => None,
    };
    if let Some(looks) = line {
        let path: String = series
            .points
            .iter()
            .map(place)
            .enumerate()
            .map(|(index, (a, b))| format!("{}{a:.1} {b:.1}", if index == 0 { 'M' } else { 'L' }))
            .collect();
        let _ = writeln!(
            svg,
            r#"<path d="{path}" stroke="{color}" {looks} fill="none" stroke-linejoin="round"/>"#
        );
    }
    let marked = if series.style == Style::Fit { &[][..] } else { &series.points[..] };
    for point in marked {
        let fill = if matches!(series.style, Style::Line(_)) { color } else { "#ffffff" };
        let _ = writeln!(svg, "{}", marker(kind, place(point), color, fill));
    }
}

/// A circle, square, triangle, diamond or inverted triangle around a place.
fn marker(kind: usize, (x, y): (f64, f64), stroke: &str, fill: &str) -> String {
    let looks = format!(r#"stroke="{stroke}" stroke-width="1.6" fill="{fill}""#);
    let polygon = |corners: &[(f64, f64)]| {
        let corners: Vec<String> =
            corners.iter().map(|(dx, dy)| format!("{:.1},{:.1}", x + dx, y + dy)).collect();
        format!(r#"<polygon points="{}" {looks}/>"#, corners.join(" "))
    };
    match kind % 5 {
        0 => format!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="4.2" {looks}/>"#),
        1 => polygon(&[(-3.8, -3.8), (3.8, -3.8), (3.8, 3.8), (-3.8, 3.8)]),
        2 => polygon(&[(0.0, -5.0), (4.6, 3.6), (-4.6, 3.6)]),
        3 => polygon(&[(0.0, -5.4), (5.4, 0.0), (0.0, 5.4), (-5.4, 0.0)]),
        _ => polygon(&[(0.0, 5.0), (4.6, -3.6), (-4.6, -3.6)]),
    }
}

/// Formats a number for people: 0.02, 5, 10,000.
pub(super) fn number(value: f64) -> String {
    if value < 1000.0 {
        return format!("{value}");
    }
    let digits = format!("{value:.0}");
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_evenly_spaced() {
        let axis = Axis { low: -2.0, high: 2.0, from_px: 100.0, to_px: 500.0 };
        assert!((axis.px(0.1) - 200.0).abs() < 1e-9);
        assert!((axis.px(100.0) - 500.0).abs() < 1e-9);
        let labelled: Vec<f64> = axis.ticks().into_iter().filter(|tick| tick.1).map(|tick| tick.0).collect();
        assert_eq!(labelled, [0.01, 0.1, 1.0, 10.0, 100.0]);
    }

    #[test]
    fn a_short_axis_has_numbers_too() {
        let axis = Axis::around([3.0, 4.0].into_iter(), 0.0, 100.0);
        assert!(axis.ticks().iter().filter(|tick| tick.1).count() >= 2);
        assert!(axis.px(3.0) > 0.0 && axis.px(4.0) < 100.0);
        // Without values there is no picture, and no panic.
        assert!(Axis::around([].into_iter(), 0.0, 100.0).px(2.0).is_finite());
    }

    #[test]
    fn numbers_are_for_reading() {
        assert_eq!([0.02, 5.0, 100.0, 1e4, 1.5e6].map(number), ["0.02", "5", "100", "10,000", "1,500,000"]);
    }

    #[test]
    fn labels_do_not_cover_each_other() {
        let series = |name: &str| Series {
            name: name.into(),
            style: Style::Line(0),
            points: vec![(1.0, 1.0)],
            aside: vec![],
        };
        let plot = Plot {
            title: "a < b & c".into(),
            subtitle: String::new(),
            x_label: String::new(),
            y_label: String::new(),
            series: ["one", "two", "three"].map(series).into(),
        };
        let svg = plot.to_svg();
        assert!(svg.contains("a &lt; b &amp; c"));
        let heights: Vec<f64> = svg
            .lines()
            .filter(|line| line.contains(r#"font-weight="bold" fill"#) && !line.contains("font-size"))
            .filter_map(|line| line.split(" y=\"").nth(1)?.split('"').next()?.parse().ok())
            .collect();
        assert_eq!(heights.len(), 3);
        assert!(heights.windows(2).all(|pair| pair[1] - pair[0] >= LINE_HEIGHT - 0.1), "{heights:?}");
    }
}
