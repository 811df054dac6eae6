//! `sunfleck bench --all-light`: the grid of indirect light and random walks, error against time. In goes a
//! file, out comes a table.

use super::{BenchArguments, CliError, Subject, answer, pool, tell};
use sunfleck::bench::{self, AllLightPlan, Stage};
use sunfleck::scene::Bounces;

pub(super) fn run(arguments: &BenchArguments, subject: &Subject) -> Result<(), CliError> {
    let quick = arguments.quick;
    let exposure = subject.plan.exposure_of(subject.shutter);
    if subject.settings.bounces == Bounces::NONE {
        tell("the input asks for direct light and single scattering alone, so both ways are the same");
    }
    let plan = AllLightPlan {
        stage: Stage {
            exposure: &exposure,
            size: subject.size,
            mirror_depth: subject.settings.mirror_depth,
            planes: (bench::depth_m(exposure.middle()), subject.settings.march_step_m),
        },
        bounces: subject.settings.bounces,
        reference_samples: arguments.reference_samples.unwrap_or(if quick { 32 } else { 256 }),
        most_samples: arguments.most_samples.unwrap_or(if quick { 4 } else { 64 }),
        rounds: arguments.rounds.unwrap_or(if quick { 1 } else { 3 }) as usize,
        seed: subject.settings.seed,
    };
    let many = pool(arguments.threads)?;
    let measured = pool(Some(1))?.install(|| bench::measure_all_light(&plan, &many, &tell));
    answer(bench::all_light_table(&measured).trim_end())
}
