//! Error against run time, for any scene. In goes a snapshot, out come data: the time of each method and its
//! error against a converged picture. Invariant: this module prints and writes nothing; compared methods take
//! turns in one run.

pub mod brute_force;
mod cost;
mod error;
mod literal;
mod method;
mod plot;
mod reference;
mod report;
mod study;

pub use cost::{Cost, PowerLaw, cost_of, front};
pub use error::{RelativeErrors, colors, mean, percentile};
pub use literal::{Literal, depth_m};
pub use method::{Effort, Method, Stage, timed};
pub use plot::{Plot, Series, Style};
pub use reference::Reference;
pub use report::{csv, plot, seconds, table};
pub use study::{Point, Study, StudyPlan, run};
