//! `sunfleck bench --scaling`: how the cost grows. In goes a file, out come exponents, CSV and a
//! plot for each quantity.

use super::{BenchArguments, CliError, Subject, answer, output, tell, write};
use crate::bench::{Quantity, ScalingPlan, growth_csv, growth_plot, growth_table, measure_growth};
use crate::scene::Size;

pub(super) fn run(arguments: &BenchArguments, subject: &Subject) -> Result<(), CliError> {
    let quick = arguments.quick;
    let plan = ScalingPlan {
        scene: &subject.scene,
        camera: subject.camera,
        shutter: subject.shutter,
        size: subject.size,
        mirror_depth: subject.settings.mirror_depth,
        samples: 4,
        rounds: arguments.rounds.unwrap_or(if quick { 1 } else { 2 }) as usize,
        longest_s: arguments.longest.unwrap_or(if quick { 1.0 } else { 20.0 }),
    };
    let growths: Vec<_> = Quantity::ALL
        .into_iter()
        .map(|quantity| {
            tell(quantity.name());
            measure_growth(&plan, quantity)
        })
        .collect();
    let Size { width, height } = subject.size;
    let title =
        format!("{}, {width} x {height} pixels, slices, {} samples", subject.settings.name, plan.samples);
    answer(&format!("{title}\n\n{}", growth_table(&growths)));
    write(&output(arguments.csv.as_deref(), subject, "scaling.csv"), &growth_csv(&growths))?;
    for growth in growths.iter().filter(|growth| growth.points.len() > 1) {
        let kind = format!("{}.svg", growth.quantity.name());
        let path = match &arguments.svg {
            Some(path) => path.with_extension(&kind),
            None => output(None, subject, &kind),
        };
        write(&path, &growth_plot(growth, &title).to_svg())?;
    }
    Ok(())
}
