//! `sunfleck bench --scaling`: how the cost grows. In goes a file, out come exponents, CSV and a
//! plot for each quantity. Invariant: what was measured before an interruption is in the files.

use super::{BenchArguments, CliError, Subject, answer, output, save, tell, write};
use sunfleck::bench::{Growth, Quantity, ScalingPlan, growth_csv, growth_plot, growth_table, measure_growth};
use sunfleck::diagnostic::shown;
use sunfleck::scene::Size;

/// Measures `quantities`, or all of them if there are none.
pub(super) fn run(
    arguments: &BenchArguments,
    subject: &Subject,
    quantities: &[Quantity],
) -> Result<(), CliError> {
    let quick = arguments.quick;
    let plan = ScalingPlan {
        scene: subject.scene,
        camera: subject.plan.camera,
        shutter: subject.shutter,
        size: subject.size,
        mirror_depth: subject.settings.mirror_depth,
        samples: 4,
        rounds: arguments.rounds.unwrap_or(if quick { 1 } else { 2 }) as usize,
        longest_s: arguments.longest.unwrap_or(if quick { 1.0 } else { 20.0 }),
    };
    let Size { width, height } = subject.size;
    let title =
        format!("{}, {width} x {height} pixels, slices, {} samples", subject.settings.name, plan.samples);
    let csv = output(arguments.csv.as_deref(), subject, "scaling.csv");
    let mut growths: Vec<Growth> = Vec::new();
    for quantity in Quantity::ALL {
        if !quantities.is_empty() && !quantities.contains(&quantity) {
            continue;
        }
        tell(quantity.name());
        let growth = measure_growth(&plan, quantity);
        if growth.points.len() > 1 {
            let kind = format!("{}.svg", quantity.name());
            let path = match &arguments.svg {
                Some(path) => path.with_extension(&kind),
                None => output(None, subject, &kind),
            };
            write(&path, &growth_plot(&growth, &title).to_svg())?;
        }
        growths.push(growth);
        save(&csv, &growth_csv(&growths))?;
    }
    answer(&format!("{} was written\n\n{title}\n\n{}", shown(&csv), growth_table(&growths)))
}
