//! Report of how a cost grows, for people and for programs. In go [`Growth`]s, out come a table, CSV and
//! plots. Invariant: an exponent never stands without its standard error.

use super::report::seconds;
use super::{Growth, Plot, PowerLaw, Quantity, Series, Style};
use std::fmt::Write;

/// Exponents, then the points that they were fitted to.
pub fn growth_table(growths: &[Growth]) -> String {
    let mut text =
        format!("{:<10} {:>20}   {:<17} {}\n", "quantity", "from, to", "time grows with", "seconds");
    for growth in growths {
        let (Some(first), Some(last)) = (growth.points.first(), growth.points.last()) else { continue };
        let range = format!("{}, {}", seconds(first.0), seconds(last.0));
        let times: Vec<String> = growth.points.iter().map(|point| seconds(point.1)).collect();
        let name = growth.quantity.name();
        let _ = writeln!(text, "{name:<10} {range:>20}   {:<17} {}", exponent(growth.law), times.join("  "));
    }
    text
}

/// Such as `^0.52 +- 0.03`.
fn exponent(law: Option<PowerLaw>) -> String {
    match law {
        Some(law) if law.standard_error.is_finite() => {
            format!("^{:.2} +- {:.2}", law.exponent, law.standard_error)
        }
        Some(law) => format!("^{:.2} (2 points)", law.exponent),
        None => String::from("-"),
    }
}

/// One row a point, with a heading.
pub fn growth_csv(growths: &[Growth]) -> String {
    let mut text = String::from("quantity,value,seconds,exponent,exponent_standard_error\n");
    for growth in growths {
        let law = growth.law.map_or(String::from(","), |law| {
            let error = if law.standard_error.is_finite() {
                format!("{:.4}", law.standard_error)
            } else {
                String::new()
            };
            format!("{:.4},{error}", law.exponent)
        });
        for (value, time) in &growth.points {
            let _ = writeln!(text, "{},{value},{time:.6},{law}", growth.quantity.name());
        }
    }
    text
}

/// The points and the line that fits them.
pub fn growth_plot(growth: &Growth, title: &str) -> Plot {
    let wall = growth.quantity == Quantity::Threads;
    let mut series = Vec::new();
    if let (Some(law), Some(first), Some(last)) = (growth.law, growth.points.first(), growth.points.last()) {
        let line = [first.0, last.0].map(|value| (value, law.at(value))).to_vec();
        series.push(Series {
            name: exponent(growth.law),
            style: Style::Fit,
            points: line,
            aside: Vec::new(),
        });
    }
    let measured = Series {
        name: String::new(),
        style: Style::Line(0),
        points: growth.points.clone(),
        aside: Vec::new(),
    };
    series.push(measured);
    Plot {
        title: title.to_owned(),
        subtitle: format!("time over {}, {}", growth.quantity.name(), exponent(growth.law)),
        x_label: growth.quantity.label().to_owned(),
        y_label: String::from(if wall {
            "seconds by the clock"
        } else {
            "processor time of the picture, seconds"
        }),
        series,
    }
}
