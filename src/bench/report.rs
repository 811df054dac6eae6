//! A study as text for people and for programs. In goes a [`Study`], out come a table, CSV and a plot.
//! Invariant: each of them marks values that are extrapolated or within the reference's noise.

use super::cost::{Cost, cost_of, front};
use super::plot::number;
use super::{Effort, Method, Plot, Point, Series, Study, Style};
use clap::ValueEnum;
use std::fmt::Write;

/// Error levels whose times are reported.
const LEVELS: [f64; 3] = [0.05, 0.01, 0.001];
/// Heading of the CSV.
const COLUMNS: &str = "method,samples,steps,tolerance,cpu_s,cpu_spread,rmse,rmse_with_reference_noise,mean_abs,\
    p99,max,extrapolated,note";

impl Study {
    /// Measured (seconds, error) of a method, without points lost in noise.
    fn usable(&self, method: Method) -> Vec<(f64, f64)> {
        let points = self.points.iter().filter(|point| point.method == method);
        points.filter_map(|point| Some((point.cpu_s, point.net_rmse?))).collect()
    }

    /// The methods that were measured, in the order of [`Method`].
    fn methods(&self) -> impl Iterator<Item = Method> {
        Method::value_variants()
            .iter()
            .copied()
            .filter(|&method| self.points.iter().any(|point| point.method == method))
    }

    /// Names of the peers' renderers, each once.
    fn renderers(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for peer in &self.peers {
            if !names.contains(&peer.renderer.as_str()) {
                names.push(&peer.renderer);
            }
        }
        names
    }

    fn peer_points(&self, renderer: &str) -> Vec<(f64, f64)> {
        let peers = self.peers.iter().filter(|peer| peer.renderer == renderer);
        peers.map(|peer| (peer.cpu_s, peer.rmse)).collect()
    }

    /// Names and fronts of all methods and peers with several errors.
    fn fronts(&self) -> Vec<(String, Vec<(f64, f64)>)> {
        let own = self.methods().map(|method| (method.name(), front(&self.usable(method))));
        let renderers = self.renderers();
        let peers = renderers.iter().map(|name| ((*name).to_owned(), front(&self.peer_points(name))));
        own.chain(peers).collect()
    }
}

/// Number of samples a pixel, or the tolerance.
fn told_samples(effort: &Effort) -> String {
    let percent = |tolerance| format!("{:.2} %", 100.0 * tolerance);
    effort.tolerance.map_or_else(|| effort.samples.to_string(), percent)
}

/// Note on a point's accuracy.
fn note(point: &Point) -> String {
    match point.literal {
        Some(literal) => {
            let deviation = literal.deviation.map(|deviation| {
                format!("; their shafts differ by {deviation:.0e} from those through the tree")
            });
            format!("time extrapolated from {} pixels{}", literal.pixels, deviation.unwrap_or_default())
        }
        None if point.net_rmse.is_none() => String::from("at the reference's own noise"),
        None => String::new(),
    }
}

/// The study as a table, followed by the times to reach given errors.
pub fn table(study: &Study) -> String {
    let mut text = format!("{}\n{}\n\n", study.title, study.reference_note);
    let _ = writeln!(
        text,
        "{:<15} {:>7} {:>5} {:>10} {:>6} {:>9} {:>9} {:>8} {:>8}",
        "method", "samples", "steps", "CPU s", "+", "RMSE %", "mean %", "p99 %", "max %"
    );
    for point in &study.points {
        let steps = point.effort.steps.map_or(String::from("-"), |steps| steps.to_string());
        let samples = told_samples(&point.effort);
        let rmse = point
            .net_rmse
            .map_or(format!("< {:.3}", 100.0 * point.errors.rmse), |rmse| format!("{:.3}", 100.0 * rmse));
        let percent = |error: f64, digits: usize| format!("{:.digits$}", 100.0 * error);
        let _ = writeln!(
            text,
            "{:<15} {samples:>7} {steps:>5} {:>10} {:>5.0}% {rmse:>9} {:>9} {:>8} {:>8}  {}",
            point.method.name(),
            seconds(point.cpu_s),
            100.0 * point.spread,
            percent(point.errors.mean_abs, 3),
            percent(point.errors.p99, 2),
            percent(point.errors.max, 0),
            note(point)
        );
    }
    for peer in &study.peers {
        let _ = writeln!(
            text,
            "{:<15} {:>7} {:>5} {:>10} {:>6} {:>9.3}  measured elsewhere",
            peer.renderer,
            peer.samples,
            "-",
            seconds(peer.cpu_s),
            "",
            100.0 * peer.rmse
        );
    }
    text.push_str(&costs(study));
    text
}

fn costs(study: &Study) -> String {
    let fronts = study.fronts();
    let march = fronts.iter().find(|(name, _)| *name == Method::March.name()).map(|(_, front)| front);
    let levels = |text: &mut String, told: &dyn Fn(f64) -> String| {
        for level in LEVELS {
            let _ = write!(text, " {:>9}", told(level));
        }
    };
    let mut text = format!("\n{:<30}", "CPU seconds to an RMSE of");
    levels(&mut text, &|level| format!("{} %", 100.0 * level));
    if march.is_some() {
        text.push_str("   times as fast as march:");
    }
    text.push('\n');
    for (name, own) in &fronts {
        let cost = |level| match cost_of(own, level) {
            // The whole front is extrapolated from a part of the picture.
            Cost::AtMost(time) | Cost::Measured(time) if *name == Method::Literal.name() => {
                Cost::Extrapolated(time)
            }
            cost => cost,
        };
        let _ = write!(text, "{name:<30}");
        levels(&mut text, &|level| told(cost(level)));
        if let Some(march) = march {
            text.push_str("  ");
            let ratio = |level| Some(cost_of(march, level).seconds()? / cost(level).seconds()?);
            levels(&mut text, &|level| ratio(level).map_or(String::from("-"), rounded));
        }
        text.push('\n');
    }
    text.push_str("~ extrapolated   < the cheapest point does better   - not to be had by more effort\n");
    text
}

fn told(cost: Cost) -> String {
    match cost {
        Cost::Measured(time) => seconds(time),
        Cost::AtMost(time) => format!("< {}", seconds(time)),
        Cost::Extrapolated(time) => format!("~ {}", seconds(time)),
        Cost::Unknown => String::from("-"),
    }
}

/// Formats a time with three significant digits.
pub fn seconds(value: f64) -> String {
    let digits = (2.0 - value.abs().log10().floor()).clamp(0.0, 4.0) as usize;
    if value < 1000.0 { format!("{value:.digits$}") } else { number(value.round()) }
}

fn rounded(ratio: f64) -> String {
    match ratio {
        ..0.095 => format!("{ratio:.0e}"),
        ..9.95 => format!("{ratio:.1}"),
        _ => number(ratio.round()),
    }
}

/// One row for each point, with a heading; errors are relative to the mean of the reference.
pub fn csv(study: &Study) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = writer.write_record(COLUMNS.split(','));
    let mut row = |fields: [&str; 13]| {
        let _ = writer.write_record(fields);
    };
    for point in &study.points {
        let steps = point.effort.steps.map_or(String::new(), |steps| steps.to_string());
        row([
            &point.method.name(),
            &point.effort.samples.to_string(),
            &steps,
            &point.effort.tolerance.map_or(String::new(), |tolerance| tolerance.to_string()),
            &format!("{:.6}", point.cpu_s),
            &format!("{:.4}", point.spread),
            &point.net_rmse.map_or(String::new(), |rmse| format!("{rmse:.6e}")),
            &format!("{:.6e}", point.errors.rmse),
            &format!("{:.6e}", point.errors.mean_abs),
            &format!("{:.6e}", point.errors.p99),
            &format!("{:.6e}", point.errors.max),
            if point.literal.is_some() { "true" } else { "false" },
            &note(point),
        ]);
    }
    for peer in &study.peers {
        let (samples, cpu_s, rmse) =
            (peer.samples.to_string(), format!("{:.6}", peer.cpu_s), format!("{:.6e}", peer.rmse));
        row([
            &peer.renderer,
            &samples,
            "",
            "",
            &cpu_s,
            "",
            &rmse,
            "",
            "",
            "",
            "",
            "false",
            "measured elsewhere",
        ]);
    }
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}

/// Error over time, both logarithmic.
pub fn plot(study: &Study) -> Plot {
    let percent = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        points.into_iter().map(|(seconds, error)| (seconds, 100.0 * error)).collect()
    };
    let looks = |method: Method| match method {
        Method::Slices => 0,
        Method::Segments => 1,
        Method::Equiangular => 2,
        Method::March => 3,
        Method::MarchJittered => 4,
        // These two are never in one plot.
        Method::Literal | Method::Paths => 5,
        // The colour of slices, with another marker.
        Method::SlicesUntil => 8,
    };
    let own = study.methods().map(|method| {
        let all = study.usable(method);
        let best = front(&all);
        let aside = all.into_iter().filter(|point| !best.contains(point)).collect();
        let (name, style) = match method {
            Method::Literal => {
                ("every triangle, every step (extrapolated)".into(), Style::Hollow(looks(method)))
            }
            _ => (method.name(), Style::Line(looks(method))),
        };
        Series { name, style, points: percent(best), aside: percent(aside) }
    });
    let renderers = study.renderers();
    let peers = renderers.iter().enumerate().map(|(index, name)| Series {
        name: (*name).to_owned(),
        style: Style::Dashed(6 + index),
        points: percent(study.peer_points(name)),
        aside: Vec::new(),
    });
    Plot {
        title: study.title.clone(),
        subtitle: study.reference_note.clone(),
        x_label: String::from("processor time of the picture, seconds"),
        y_label: String::from("root mean square error, % of the mean"),
        series: own.chain(peers).collect(),
    }
}
