//! Source iteration with a given number of orders of scattering. In go the first order's source and the
//! incident radiance of each order, out comes the light of these orders. Invariant: incident radiance joins
//! light of the same number of scatterings.

use super::angular_radiance::AngularRadiance;
use super::boundary::BoundaryCondition;
use super::moments::Moments;
use super::source_iteration::{Source, SourceIteration};
use super::sweep::Swept;
use super::wanted::Wanted;

/// Number of orders that a finer grid gets apart; the last of them includes all later ones.
pub(super) const MOST_ORDERS: usize = 16;

impl SourceIteration<'_> {
    /// Adds so many orders to `light`. `first` is the first order if it has been swept along fine ordinates;
    /// `later` is added to the source of the second. Returns the degrees for the last scattering, and
    /// radiances for a finer grid.
    pub(super) fn count(
        &mut self,
        orders: u32,
        (mut source, later): (Source, &Source),
        mut first: Option<Swept>,
        light: &mut Moments,
    ) -> (Swept, Vec<AngularRadiance>) {
        let problem = self.problem;
        let (nothing, wanted) = (source.emptied(), Wanted { moments: true, ..problem.last(true) });
        let (mut last, mut radiances) = (None, Vec::new());
        for order in 0..orders as usize {
            if (problem.cancelled)() {
                break;
            }
            let mut incident = problem.surrounding.scattered.get(order);
            let mut swept = first.take().unwrap_or_else(|| {
                let together = incident.take_if(|incident| !incident.is_fine);
                let condition = together.map_or(BoundaryCondition::Vacuum, BoundaryCondition::Incident);
                self.sweep(&source, condition, &wanted)
            });
            if let Some(incident) = incident {
                let entering = self.sweep_incident(incident, &nothing, &wanted);
                swept.moments.add(&entering.moments, [1.0; 3]);
                swept.add_last(&entering);
            }
            light.add(&swept.moments, [1.0; 3]);
            tell(&mut radiances, swept.radiances.take());
            source = problem.scatter(&swept.moments, true);
            if order == 0 {
                source.add(later, [1.0; 3]);
            }
            Swept::add_to(&mut last, swept);
        }
        (last.unwrap_or_else(|| self.sweep(&nothing, BoundaryCondition::Vacuum, &wanted)), radiances)
    }
}

/// Adds an order to those of a finer grid.
fn tell(radiances: &mut Vec<AngularRadiance>, of_order: Option<AngularRadiance>) {
    match (radiances.get_mut(MOST_ORDERS - 1), of_order) {
        (Some(last), Some(of_order)) => last.add(&of_order),
        (_, of_order) => radiances.extend(of_order),
    }
}
