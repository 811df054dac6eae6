//! Many flights at once. In go leaves, out come their flights, in the order in which they end. Invariant: a
//! flight has the same bits as that of the leaf alone. Plates step in lanes. At the end of a leg, its leaf
//! alone computes the next one; at the end of a flight, the next leaf takes its lane.

use super::flight::{Journey, Leg};
use super::lanes::{LANES, Lanes};
use super::leaf::{Flight, Leaf, Surroundings};
use super::plate::{Plate, State};

/// Plates in lanes, each on its own leg.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Abreast {
    plate: Plate<Lanes>,
    state: State<Lanes>,
    weight: [Lanes; 2],
    time: Lanes,
}

impl Abreast {
    /// Advances all plates by a number of steps.
    pub(super) fn advance(&mut self, steps: usize) {
        let Self { plate, mut state, weight, time } = *self;
        for _ in 0..steps {
            state = plate.step(state, weight, time);
        }
        self.state = state;
    }

    pub(super) fn state(&self, lane: usize) -> State {
        let State { u, v, w, cos, sin, x, y } = self.state;
        let [u, v, w, cos, sin, x, y] = [u, v, w, cos, sin, x, y].map(|lanes| lanes.0[lane]);
        State { u, v, w, cos, sin, x, y }
    }

    pub(super) fn set(&mut self, lane: usize, leg: &Leg) {
        let Leg { plate, state, weight, time, .. } = leg;
        let State { u, v, w, cos, sin, x, y } = &mut self.state;
        let to = [u, v, w, cos, sin, x, y];
        let State { u, v, w, cos, sin, x, y } = *state;
        for (to, from) in to.into_iter().zip([u, v, w, cos, sin, x, y]) {
            to.0[lane] = from;
        }
        self.plate.inertia.0[lane] = plate.inertia;
        self.plate.damping.0[lane] = plate.damping;
        self.plate.curl.0[lane] = plate.curl;
        self.weight[0].0[lane] = weight[0];
        self.weight[1].0[lane] = weight[1];
        self.time.0[lane] = *time;
    }
}

/// A leaf in its lane.
struct Seat {
    number: usize,
    journey: Journey,
    steps_left: usize,
}

/// Flies all leaves; calls `ended` with each leaf's index and flight.
pub(super) fn fly(
    leaves: impl Iterator<Item = Leaf>,
    around: Surroundings<'_>,
    mut ended: impl FnMut(usize, Flight),
) {
    let mut waiting = leaves.enumerate();
    let mut plates = Abreast::default();
    let mut seats: [Option<Seat>; LANES] = Default::default();
    loop {
        for (lane, seat) in seats.iter_mut().enumerate() {
            if seat.as_ref().is_some_and(|seat| seat.steps_left > 0) {
                continue;
            }
            if let Some(Seat { number, journey, .. }) = seat
                && let Some(flight) = journey.arrive(plates.state(lane), around)
            {
                ended(*number, flight);
                *seat = None;
            }
            while seat.is_none()
                && let Some((number, leaf)) = waiting.next()
            {
                let interval_s = leaf.interval_s();
                match Journey::released(leaf, interval_s, around) {
                    Ok(journey) => *seat = Some(Seat { number, journey, steps_left: 0 }),
                    Err(flight) => ended(number, flight),
                }
            }
            if let Some(seat) = seat {
                let leg = seat.journey.depart(around);
                plates.set(lane, &leg);
                seat.steps_left = leg.steps;
            }
        }
        let Some(steps) = seats.iter().flatten().map(|seat| seat.steps_left).min() else { return };
        plates.advance(steps);
        seats.iter_mut().flatten().for_each(|seat| seat.steps_left -= steps);
    }
}
