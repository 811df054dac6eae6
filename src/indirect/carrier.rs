//! Light of one channel along all ordinates that cross the same planes, one way and the other. In go sources,
//! out come moments. Invariant: an ordinate and its opposite share what half a cell does to light.

use super::beam::Beam;
use super::extinction::Shade;
use super::faces::TowardsFaces;
use super::grid::{Corners, Grid};
use super::harmonics::{COUNT, basis, fourth_basis, third_basis};
use super::high_degrees::{HIGH, HIGH_ODD, high_basis};
use super::highlights::Highlights;
use super::inflow::{Arriving, Inflow};
use super::matter::Matter;
use super::moments::Moments;
use super::ordinates::{Ordinate, Ordinates};
use super::planes::{Layout, Planes};
use super::sweep_kernels::{Accumulate, AccumulateDegree, AddBeam, CrossRows, Prepare};
use super::walls::{WalledNode, Walls, link_of};
use super::wanted::Wanted;
use crate::accel::vectorized;
use glam::DVec3;

/// Where light of a sweep comes from.
#[derive(Clone, Copy)]
pub(super) struct Sources<'a> {
    /// Of matter, per metre and steradian.
    pub(super) of_matter: &'a Moments,
    /// Of fog in suns' light beyond harmonics.
    pub(super) beams: &'a [Beam],
    /// Radiance that leaves each wall patch, by channel.
    pub(super) of_walls: &'a [Vec<f32>; 3],
    /// What they send out beyond that along single ordinates.
    pub(super) highlights: Option<&'a Highlights>,
    pub(super) inflow: Inflow<'a>,
}

/// One of nine: of an axis and a channel.
pub(super) struct Carrier<'a> {
    pub(super) axis: usize,
    pub(super) channel: usize,
    /// By harmonic, then by node.
    pub(super) moments: Vec<f32>,
    /// The same of degrees 3 and 4, for the last scattering.
    pub(super) third: Vec<f32>,
    pub(super) fourth: Vec<f32>,
    /// And of degrees 5 and 6.
    pub(super) high: Vec<f32>,
    /// What of it travels towards walls.
    pub(super) towards_faces: TowardsFaces,
    /// Each ordinate's number and radiance, where a grid within this one needs it.
    pub(super) radiances: Vec<(usize, Vec<f32>)>,
    cell_m: f64,
    planes: Planes,
    matter: &'a Matter,
    /// Nodes with leaves, in the order of `Matter::leaves`.
    leaf_nodes: Vec<usize>,
    fog_extinction: Vec<f32>,
    /// By plane.
    walled: Vec<Vec<Walled<'a>>>,
    pairs: Vec<Pair>,
    /// Of each node for one pair: what half a cell lets through, what it adds, and the
    /// radiance in the middle.
    leaf_extinction: Vec<f32>,
    through: Vec<f32>,
    added: [Vec<f32>; 2],
    radiance: [Vec<f32>; 2],
    /// What leaves the cells of a plane, with a rim of what comes from outside.
    before: Vec<f32>,
    behind: Vec<f32>,
    /// What leaves walls along one ordinate.
    of_walls: Vec<f32>,
}

/// An ordinate that goes forwards along the axis, and its opposite.
struct Pair {
    ordinate: Ordinate,
    /// Their numbers.
    numbers: [usize; 2],
}

/// A node some of whose neighbours are behind walls.
struct Walled<'a> {
    links: &'a WalledNode,
    /// Among the nodes as they are laid, and in its plane.
    node: usize,
    here: usize,
}

/// The four cells that light comes from: steps along rows and columns, and shares.
struct Taps {
    /// Against the light's way along the planes.
    backwards: i32,
    steps: [i32; 2],
    shares: [f32; 4],
}

impl Taps {
    fn of(direction: DVec3, planes: &Planes) -> Self {
        let along = direction[planes.axis].abs();
        let back = [1, 2].map(|which| -direction[planes.axes[which]] / along);
        let [row, column] = back.map(f64::abs);
        let shares = [(1.0 - row) * (1.0 - column), (1.0 - row) * column, row * (1.0 - column), row * column];
        Self {
            backwards: -direction[planes.axis].signum() as i32,
            steps: back.map(|back| back.signum() as i32),
            shares: shares.map(|share| share as f32),
        }
    }

    /// The step to one of them, along planes, rows and columns.
    fn step(&self, tap: usize) -> [i32; 3] {
        let [row, column] = self.steps;
        [self.backwards, if tap & 2 != 0 { row } else { 0 }, if tap & 1 != 0 { column } else { 0 }]
    }
}

impl<'a> Carrier<'a> {
    pub(super) fn new(
        grid: &Grid,
        matter: &'a Matter,
        (walls, ordinates): (&'a Walls, &Ordinates),
        layout: Layout,
        [axis, channel]: [usize; 2],
    ) -> Self {
        let planes = Planes::new(layout, axis);
        let count = grid.count();
        let rim = vec![0.0; (planes.count[1] + 2) * planes.row()];
        let nodes = || vec![0.0; count];
        Self {
            axis,
            channel,
            moments: Vec::new(),
            third: Vec::new(),
            fourth: Vec::new(),
            high: Vec::new(),
            towards_faces: TowardsFaces::new(&walls.faces, |node| layout.node(node)),
            radiances: Vec::new(),
            cell_m: grid.cell_m,
            planes,
            matter,
            leaf_nodes: matter.leaves.iter().map(|leaves| layout.node(leaves.node)).collect(),
            fog_extinction: layout.of_grid(&matter.extinction.fog[channel]),
            walled: walled(grid, walls, layout, &planes),
            pairs: pairs(ordinates, axis),
            leaf_extinction: nodes(),
            through: nodes(),
            added: [nodes(), nodes()],
            radiance: [nodes(), nodes()],
            before: rim.clone(),
            behind: rim,
            of_walls: Vec::new(),
        }
    }

    /// Along all of its ordinates.
    pub(super) fn carry(
        &mut self,
        sources: &Sources,
        wanted: &Wanted,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) {
        let count = self.through.len();
        let room = |is_wanted: bool, moments: usize| vec![0.0; if is_wanted { moments * count } else { 0 }];
        self.moments = room(wanted.moments, COUNT);
        self.third = room(wanted.third, COUNT);
        self.fourth = room(wanted.last, COUNT);
        self.high = room(wanted.high, HIGH);
        self.towards_faces.clear(wanted);
        self.radiances.clear();
        for number in 0..self.pairs.len() {
            if cancelled() {
                return;
            }
            let ordinate = self.carry_pair(number, sources);
            self.add_up(ordinate, wanted);
            if let Some(places) = wanted.radiances {
                let found = self.radiance.each_ref().map(|of_nodes| means(of_nodes, places));
                self.radiances.extend(self.pairs[number].numbers.into_iter().zip(found));
            }
        }
    }

    /// Has no moments any more.
    pub(super) fn clear(&mut self) {
        for moments in [&mut self.moments, &mut self.third, &mut self.fourth, &mut self.high] {
            *moments = Vec::new();
        }
    }

    fn add_up(&mut self, Ordinate { direction, weight }: Ordinate, wanted: &Wanted) {
        let [along, against] = &self.radiance;
        for (direction, radiance) in [(direction, along), (-direction, against)] {
            self.towards_faces.add(Ordinate { direction, weight }, radiance, wanted);
        }
        if wanted.moments {
            let factors = basis(direction).map(|value| (weight * value) as f32);
            vectorized(Accumulate { along, against, factors, moments: &mut self.moments });
        }
        if wanted.last {
            let factors = &fourth_basis(direction).map(|value| (weight * value) as f32);
            vectorized(AccumulateDegree { along, against, back: 1.0, factors, moments: &mut self.fourth });
        }
        if wanted.third {
            let factors = &third_basis(direction).map(|value| (weight * value) as f32);
            vectorized(AccumulateDegree { along, against, back: -1.0, factors, moments: &mut self.third });
        }
        if wanted.high {
            let factors = high_basis(direction).map(|value| (weight * value) as f32);
            let (odd, even) = factors.split_at(HIGH_ODD);
            let (moments, of_even) = self.high.split_at_mut(HIGH_ODD * along.len());
            vectorized(AccumulateDegree { along, against, back: -1.0, factors: odd, moments });
            vectorized(AccumulateDegree { along, against, back: 1.0, factors: even, moments: of_even });
        }
    }

    /// Radiance along an ordinate and against it.
    fn carry_pair(&mut self, number: usize, sources: &Sources) -> Ordinate {
        let Pair { ordinate, numbers } = self.pairs[number];
        self.prepare(ordinate.direction, sources);
        for (side, direction) in [ordinate.direction, -ordinate.direction].into_iter().enumerate() {
            let arriving = Arriving { inflow: sources.inflow, ordinate: numbers[side] };
            self.of_walls.clone_from(&sources.of_walls[self.channel]);
            if let Some(highlights) = sources.highlights {
                highlights.add_to(&mut self.of_walls, self.channel, numbers[side]);
            }
            self.cross(side, &Taps::of(direction, &self.planes), &arriving);
        }
        ordinate
    }

    fn prepare(&mut self, direction: DVec3, sources: &Sources) {
        let products = Shade::products(direction);
        for (shade, &node) in self.matter.extinction.shades.iter().zip(&self.leaf_nodes) {
            self.leaf_extinction[node] = shade.along(&products);
        }
        let [along, against] = &mut self.added;
        vectorized(Prepare {
            sources: std::array::from_fn(|index| sources.of_matter.channel(self.channel, index)),
            basis: &basis(direction).map(|value| value as f32),
            fog_extinction: &self.fog_extinction,
            leaf_extinction: &self.leaf_extinction,
            half_way: (0.5 * self.cell_m / direction[self.axis].abs()) as f32,
            through: &mut self.through,
            added: [along, against],
        });
        for beam in sources.beams {
            let [along, against] = &mut self.added;
            vectorized(AddBeam {
                sources: beam.channel(self.channel),
                factors: beam.factors(direction),
                fog_extinction: &self.fog_extinction,
                leaf_extinction: &self.leaf_extinction,
                half_way: (0.5 * self.cell_m / direction[self.axis].abs()) as f32,
                added: [along, against],
            });
        }
    }

    /// Carries light from plane to plane.
    fn cross(&mut self, side: usize, taps: &Taps, arriving: &Arriving) {
        let planes = self.planes;
        let row = planes.row();
        arriving.fill(
            &mut self.before,
            &planes,
            self.channel,
            if taps.backwards < 0 { -1 } else { planes.count[0] as i32 },
        );
        arriving.fill(&mut self.behind, &planes, self.channel, 0);
        let here = row + 1;
        let first = [0, 1, 2, 3].map(|tap| planes.shifted(here, taps.step(tap)));
        for number in 0..planes.count[0] {
            let plane = if taps.backwards < 0 { number } else { planes.count[0] - 1 - number };
            let nodes = plane * planes.stride[0]..;
            if let Inflow::Around(_) = arriving.inflow {
                arriving.fill(&mut self.behind, &planes, self.channel, plane as i32);
            }
            vectorized(CrossRows {
                shares: taps.shares,
                before: &self.before,
                first,
                behind: &mut self.behind,
                here,
                rows: planes.count[1],
                row,
                columns: planes.count[2],
                through: &self.through[nodes.clone()],
                added: &self.added[side][nodes.clone()],
                radiance: &mut self.radiance[side][nodes],
                stride: planes.stride[1],
            });
            self.past_walls((side, plane), taps);
            std::mem::swap(&mut self.before, &mut self.behind);
        }
    }

    /// The same for nodes some of whose neighbours are behind walls: from there comes
    /// what the walls send out.
    fn past_walls(&mut self, (side, plane): (usize, usize), taps: &Taps) {
        let planes = self.planes;
        let steps = [0, 1, 2, 3].map(|tap| taps.step(tap));
        let links = steps.map(|step| {
            let mut of_axes = [0; 3];
            (0..3).for_each(|which| of_axes[planes.axes[which]] = step[which]);
            link_of(of_axes)
        });
        for &Walled { links: seen, node, here } in &self.walled[plane] {
            let mut entering = 0.0;
            for tap in 0..4 {
                // A share of nothing may point beyond the rim.
                if taps.shares[tap] > 0.0 {
                    entering += taps.shares[tap]
                        * match seen.wall_at(links[tap]) {
                            Some(patch) => self.of_walls[patch],
                            None => self.before[planes.shifted(here, steps[tap])],
                        };
                }
            }
            let (through, added) = (self.through[node], self.added[side][node]);
            let middle = entering * through + added;
            self.radiance[side][node] = middle;
            self.behind[here] = middle * through + added;
        }
    }
}

/// At places, of what nodes about them have.
fn means(of_nodes: &[f32], places: &[Corners]) -> Vec<f32> {
    let mean = |corners: &Corners| corners.iter().map(|(node, weight)| weight as f32 * of_nodes[node]).sum();
    places.iter().map(mean).collect()
}

/// Nodes near walls, by plane.
fn walled<'a>(grid: &Grid, walls: &'a Walls, layout: Layout, planes: &Planes) -> Vec<Vec<Walled<'a>>> {
    let mut walled: Vec<Vec<Walled>> = (0..planes.count[0]).map(|_| Vec::new()).collect();
    for links in walls.nodes() {
        let place = grid.cell_of(links.node);
        let [plane, row, column] = planes.axes.map(|axis| place[axis]);
        let here = (row + 1) * planes.row() + column + 1;
        walled[plane].push(Walled { links, node: layout.node(links.node), here });
    }
    walled
}

/// The ordinates that go forwards along an axis more than along another.
fn pairs(ordinates: &Ordinates, axis: usize) -> Vec<Pair> {
    let forwards =
        |ordinate: &Ordinate| main_axis(ordinate.direction) == axis && ordinate.direction[axis] > 0.0;
    let numbered = ordinates.iter().enumerate().filter(|(_, ordinate)| forwards(ordinate));
    numbered
        .map(|(number, &ordinate)| Pair {
            ordinate,
            numbers: [number, ordinates.nearest(-ordinate.direction)],
        })
        .collect()
}

/// The one along which a direction goes most.
fn main_axis(direction: DVec3) -> usize {
    let along = direction.abs();
    // Equal ones differ by rounding.
    let most = along.max_element() - 1e-9;
    (0..3).rev().find(|axis| along[*axis] >= most).expect("one is the largest")
}
