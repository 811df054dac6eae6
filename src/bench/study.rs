//! Error against run time. In goes a scene at one moment, out comes a [`Study`]: every method at a ladder of
//! efforts. Invariant: in each round every point is measured once, with methods in turn, so disturbances of
//! the machine affect all of them.

use super::method::timed;
use super::{Effort, Literal, Method, Reference, RelativeErrors, Stage};
use crate::description::PeerRow;
use glam::DVec3;

/// Plan of the measurement.
pub struct StudyPlan<'a> {
    /// The picture.
    pub stage: Stage<'a>,
    /// Triangles of the picture, for the literal method: see [`super::brute_force::triangles`].
    pub triangles: &'a [[DVec3; 3]],
    /// Methods.
    pub methods: Vec<Method>,
    /// Number of measurements of each point, at least one.
    pub rounds: usize,
    /// Maximum time of a point, seconds: a method's ladder ends before a longer one.
    pub longest_s: f64,
    /// Maximum number of samples of a point: a ladder ends before a larger one.
    pub most_samples: u32,
    /// Seed of the measured pictures.
    pub seed: u32,
}

/// One method at one effort.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Method.
    pub method: Method,
    /// Effort.
    pub effort: Effort,
    /// Processor time of one thread for the picture: the minimum over all rounds, seconds.
    pub cpu_s: f64,
    /// Ratio of the longest round to the shortest, minus 1.
    pub spread: f64,
    /// Errors against the reference, its noise included.
    pub errors: RelativeErrors,
    /// The RMSE without the reference's noise; `None` where the noise is most of it.
    pub net_rmse: Option<f64>,
    /// Set where `cpu_s` is extrapolated from a part of the picture.
    pub literal: Option<Literal>,
}

/// All measurements.
pub struct Study {
    /// Title of the picture.
    pub title: String,
    /// Points method by method, efforts from cheap to expensive.
    pub points: Vec<Point>,
    /// Points from elsewhere, with errors relative to the mean of the reference.
    pub peers: Vec<PeerRow>,
    /// Description of the reference; the caller has the frame itself.
    pub reference_note: String,
}

/// A point during measurement, with its times so far.
struct Run {
    method: Method,
    effort: Effort,
    seconds: Vec<f64>,
    errors: RelativeErrors,
    literal: Option<Literal>,
}

/// Measures all points on the current rayon pool, which should have one thread. `report` receives a line on
/// each round.
pub fn run(plan: &StudyPlan, reference: &Reference, report: &dyn Fn(&str)) -> Vec<Point> {
    let mut runs: Vec<Run> = Vec::new();
    report(&format!("round 1 of {}", plan.rounds));
    let ladders: Vec<(Method, Vec<Effort>)> =
        plan.methods.iter().map(|&method| (method, method.ladder(plan.most_samples))).collect();
    if plan.methods.contains(&Method::Literal) {
        runs.push(literal(plan, reference));
    }
    for rung in 0..ladders.iter().map(|(_, ladder)| ladder.len()).max().unwrap_or(0) {
        for (method, ladder) in &ladders {
            let Some(&effort) = ladder.get(rung) else { continue };
            if expected_s(&runs, *method, effort).is_none_or(|seconds| seconds <= plan.longest_s) {
                runs.push(first_run(plan, reference, *method, effort));
            }
        }
    }
    for round in 1..plan.rounds {
        report(&format!("round {} of {}", round + 1, plan.rounds));
        for run in &mut runs {
            run.seconds.push(match run.method {
                Method::Literal => literal(plan, reference).seconds[0],
                method => timed(|| method.picture(&plan.stage, run.effort, plan.seed)).1,
            });
        }
    }
    let mut points: Vec<Point> = runs.iter().map(|run| point(run, reference)).collect();
    points.sort_by(|a, b| (a.method as usize).cmp(&(b.method as usize)).then(a.cpu_s.total_cmp(&b.cpu_s)));
    points
}

fn first_run(plan: &StudyPlan, reference: &Reference, method: Method, effort: Effort) -> Run {
    let (picture, seconds) = timed(|| method.picture(&plan.stage, effort, plan.seed));
    let errors = RelativeErrors::new(&picture, &reference.frame);
    Run { method, effort, seconds: vec![seconds], errors, literal: None }
}

fn literal(plan: &StudyPlan, reference: &Reference) -> Run {
    let (depth_m, step_m) = plan.stage.planes;
    let effort = Effort { steps: Some((depth_m / step_m).ceil() as u32), ..Effort::of_samples(1) };
    let measured = Literal::measure(&plan.stage, plan.triangles, 0.5 * plan.longest_s);
    let picture = Method::Literal.picture(&plan.stage, effort, plan.seed);
    let errors = RelativeErrors::new(&picture, &reference.frame);
    Run {
        method: Method::Literal,
        effort,
        seconds: vec![measured.picture_s],
        errors,
        literal: Some(measured),
    }
}

/// Maximum time of an effort, from cheaper ones of the same method; `None` for the cheapest.
fn expected_s(runs: &[Run], method: Method, effort: Effort) -> Option<f64> {
    // Only points with no more of either give a bound; the one nearest in work is best.
    let cheaper = runs.iter().filter(|run| {
        run.method == method && run.effort.samples <= effort.samples && run.effort.steps <= effort.steps
    });
    let nearest = cheaper.max_by(|a, b| a.effort.work().total_cmp(&b.effort.work()))?;
    Some(nearest.seconds[0] * effort.work() / nearest.effort.work())
}

fn point(run: &Run, reference: &Reference) -> Point {
    let shortest = run.seconds.iter().copied().fold(f64::INFINITY, f64::min);
    let longest = run.seconds.iter().copied().fold(0.0, f64::max);
    Point {
        method: run.method,
        effort: run.effort,
        cpu_s: shortest,
        spread: longest / shortest - 1.0,
        errors: run.errors,
        net_rmse: reference.net(run.errors.rmse),
        literal: run.literal,
    }
}
