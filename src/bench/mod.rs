//! Error against run time, on any scene. In goes a snapshot, out come data: what each method costs
//! and how far it is from a converged picture. Invariant: nothing here prints or writes; methods
//! that are compared take turns in one run.

mod all_light;
pub mod brute_force;
mod cost;
mod error;
mod growth_report;
mod literal;
mod method;
mod plot;
mod reference;
mod report;
mod scaling;
mod skips;
mod study;

pub use all_light::{
    AllLight, AllLightPlan, AllLightRow, measure as measure_all_light, table as all_light_table,
};
pub use cost::{Cost, PowerLaw, cost_of, front};
pub use error::{RelativeErrors, percentile};
pub use growth_report::{growth_csv, growth_plot, growth_table};
pub use literal::{Literal, depth_m};
pub use method::{Effort, Method, Stage};
pub use plot::{Plot, Series, Style};
pub use reference::Reference;
pub use report::{csv, plot, table};
pub use scaling::{Growth, Quantity, ScalingPlan, measure as measure_growth};
pub use skips::{Skip, SkipsPlan, measure as measure_skips, table as skips_table};
pub use study::{Peer, Point, Study, StudyPlan, run};
