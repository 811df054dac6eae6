//! Angle sets: all ordinates that cross the same planes, forwards or backwards, for one channel. In go
//! sources, out come moments. Invariant: an ordinate and its opposite share the attenuation of each cell.

mod cells;

use super::boundary::{BoundaryCondition, Rim};
use super::cross_sections::CrossSections;
use super::domain::Domain;
use super::emissive_bodies::EmissiveBodies;
use super::faces::TowardsFaces;
use super::first_collision_source::{BeamSource, GlossySource};
use super::grid::{Corners, Grid};
use super::harmonics::{COUNT, basis, fourth_basis, third_basis};
use super::high_degrees::{HIGH, HIGH_ODD, high_basis};
use super::moments::Moments;
use super::planes::{Layout, Planes};
use super::quadrature::{Ordinate, Quadrature};
use super::slopes::{Fog, are_dense, slopes};
use super::sweep_kernels::{Accumulate, AccumulateDegree, StepRows};
use super::upwind_stencil::UpwindStencil;
use super::walls::{CutNode, Walls};
use super::wanted::Wanted;
use super::workspace::Workspace;
use crate::accel::vectorized;
use glam::DVec3;
use std::mem::take;
use std::sync::Arc;

#[derive(Clone, Copy)]
pub(crate) struct SweepSource<'a> {
    /// Emission density of the medium, per metre and steradian.
    pub(crate) volume: &'a Moments,
    /// Scattering of beams in degrees beyond the harmonics.
    pub(crate) beams: &'a [BeamSource],
    /// Radiance that leaves each wall patch, by channel.
    pub(crate) walls: &'a [Vec<f32>; 3],
    /// Highlights of walls along single ordinates.
    pub(crate) glossy: Option<&'a GlossySource>,
    /// Small bodies that emit.
    pub(crate) bodies: Option<&'a EmissiveBodies>,
    pub(crate) incident: BoundaryCondition<'a>,
}

/// One of nine sets: one for each axis and channel.
pub(crate) struct AngleSet<'a> {
    pub(crate) axis: usize,
    pub(crate) channel: usize,
    /// Moments by harmonic, then by node.
    moments: Vec<f32>,
    /// Moments of degrees 3 and 4, for the last scattering.
    third: Vec<f32>,
    fourth: Vec<f32>,
    /// Moments of degrees 5 and 6.
    high: Vec<f32>,
    /// Moments of radiance that travels towards walls.
    towards_faces: TowardsFaces,
    /// Number of each ordinate with its radiance, where a grid within this one needs it.
    pub(crate) radiances: Vec<(usize, Vec<f32>)>,
    cell_m: f64,
    planes: Planes,
    cross_sections: &'a CrossSections,
    /// Nodes with oriented scatterers, in the order of the cross-sections.
    oriented_nodes: Arc<[usize]>,
    isotropic_extinction: Vec<f32>,
    /// Nodes with cut links, by plane.
    cut: Arc<[Vec<Cut<'a>>]>,
    /// Path through each node's cell, relative to that through a whole cell. A node has the mean over a whole
    /// cell of the matter in its room, which is denser along planes.
    stretch: Arc<[f32]>,
    /// Whether some cells are so dense that their sources have slopes; and these, by axis of the world.
    is_dense: bool,
    slopes: Option<[Vec<f32>; 3]>,
    pairs: Vec<Pair>,
    /// By node, while the set is swept.
    own: Workspace,
    /// Outgoing radiance of the cells of a plane, with incident radiance in the rim around it.
    before: Vec<f32>,
    behind: Vec<f32>,
    /// Radiance that leaves walls along one ordinate.
    walls: Vec<f32>,
}

/// Moments of an angle set: of nodes, by harmonic, and of faces of walls.
pub(super) struct SetMoments {
    pub(super) axis: usize,
    pub(super) channel: usize,
    pub(super) moments: (Vec<f32>, Vec<[f32; COUNT]>),
    pub(super) third: (Vec<f32>, Vec<[f32; COUNT]>),
    pub(super) fourth: (Vec<f32>, Vec<[f32; COUNT]>),
    /// High degrees, of nodes alone.
    pub(super) high: Vec<f32>,
}

/// An ordinate in the positive direction of the axis, and its opposite.
struct Pair {
    ordinate: Ordinate,
    /// Numbers of the two ordinates.
    numbers: [usize; 2],
}

/// A node with cut links: some of its neighbours are behind walls.
struct Cut<'a> {
    links: &'a CutNode,
    /// Index of the node in the layout, and in its plane.
    node: usize,
    here: usize,
    /// Room along rows and columns, in cells.
    room: [f32; 2],
}

impl<'a> AngleSet<'a> {
    pub(super) fn of_axis(
        &Domain { grid, cross_sections, walls }: &Domain<'a>,
        layout: Layout,
        axis: usize,
    ) -> [Self; 3] {
        let planes = Planes::new(layout, axis);
        let count = grid.count();
        let rim = vec![0.0; (planes.count[1] + 2) * planes.row()];
        let oriented_nodes: Arc<[usize]> =
            cross_sections.oriented_nodes().map(|node| layout.node(node)).collect();
        let faces = walls.faces.laid(|node| layout.node(node));
        let cut: Arc<[Vec<Cut>]> = cut_by_plane((grid, walls), layout, &planes).into();
        let mut stretch = vec![1.0; count];
        for Cut { node, room: [row, column], .. } in cut.iter().flatten() {
            stretch[*node] = 1.0 / (row * column);
        }
        let stretch: Arc<[f32]> = stretch.into();
        let cell_m = grid.cell_m as f32;
        [0, 1, 2].map(|channel| Self {
            axis,
            channel,
            moments: Vec::new(),
            third: Vec::new(),
            fourth: Vec::new(),
            high: Vec::new(),
            towards_faces: TowardsFaces::new(Arc::clone(&faces)),
            radiances: Vec::new(),
            cell_m: grid.cell_m,
            planes,
            cross_sections,
            oriented_nodes: Arc::clone(&oriented_nodes),
            isotropic_extinction: layout.of_grid(&cross_sections.extinction.isotropic[channel]),
            cut: Arc::clone(&cut),
            stretch: Arc::clone(&stretch),
            is_dense: are_dense(&cross_sections.extinction.isotropic[channel], cell_m),
            slopes: None,
            pairs: Vec::new(),
            own: Workspace::default(),
            before: rim.clone(),
            behind: rim.clone(),
            walls: Vec::new(),
        })
    }

    /// Sweeps along those ordinates of a quadrature that belong to the set, and returns the memory for it.
    pub(super) fn sweep(
        &mut self,
        quadrature: &Quadrature,
        sources: &SweepSource,
        wanted: &Wanted,
        (own, cancelled): (Workspace, &(dyn Fn() -> bool + Sync)),
    ) -> Workspace {
        (self.own, self.pairs) = (own, pairs(quadrature, self.axis));
        let count = self.stretch.len();
        let room = |is_wanted: bool, moments: usize| vec![0.0; if is_wanted { moments * count } else { 0 }];
        self.moments = room(wanted.moments, COUNT);
        self.third = room(wanted.third, COUNT);
        self.fourth = room(wanted.last, COUNT);
        self.high = room(wanted.high, HIGH);
        self.towards_faces.clear(wanted);
        self.radiances.clear();
        self.slopes = self.is_dense.then(|| {
            let fog = Fog {
                source: sources.volume.channel(self.channel, 0),
                extinction: &self.isotropic_extinction,
                with_leaves: &self.oriented_nodes,
            };
            let cut = self.cut.iter().flatten().map(|cut| cut.node);
            slopes(&self.planes, fog, self.cell_m as f32, cut)
        });
        for number in 0..self.pairs.len() {
            if cancelled() {
                break;
            }
            let ordinate = self.sweep_pair(number, sources);
            self.add_up(ordinate, wanted);
            if let Some(places) = wanted.radiances {
                let found = self.own.radiance.each_ref().map(|of_nodes| means(of_nodes, places));
                self.radiances.extend(self.pairs[number].numbers.into_iter().zip(found));
            }
        }
        self.slopes = None;
        take(&mut self.own)
    }

    /// Moves the moments out of the set.
    pub(super) fn take(&mut self) -> SetMoments {
        let towards = &mut self.towards_faces;
        SetMoments {
            axis: self.axis,
            channel: self.channel,
            moments: (take(&mut self.moments), take(&mut towards.moments)),
            third: (take(&mut self.third), take(&mut towards.third)),
            fourth: (take(&mut self.fourth), take(&mut towards.fourth)),
            high: take(&mut self.high),
        }
    }

    fn add_up(&mut self, Ordinate { direction, weight }: Ordinate, wanted: &Wanted) {
        let [along, against] = &self.own.radiance;
        for (side, direction) in [direction, -direction].into_iter().enumerate() {
            self.towards_faces.add(Ordinate { direction, weight }, &self.own.at_walls[side], wanted);
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

    /// Sweeps along an ordinate and its opposite.
    fn sweep_pair(&mut self, number: usize, sources: &SweepSource) -> Ordinate {
        let Pair { ordinate, numbers } = self.pairs[number];
        self.cells(ordinate.direction, sources);
        sources.bodies.iter().for_each(|bodies| self.add_bodies(ordinate.direction, bodies));
        for (side, direction) in [ordinate.direction, -ordinate.direction].into_iter().enumerate() {
            self.walls.clone_from(&sources.walls[self.channel]);
            if let Some(glossy) = sources.glossy {
                glossy.add_to(&mut self.walls, self.channel, numbers[side]);
            }
            let stencil = UpwindStencil::of(direction, &self.planes);
            self.sweep_planes((side, numbers[side]), &stencil, &sources.incident);
        }
        ordinate
    }

    /// Sweeps from plane to plane along one ordinate of a pair. [`StepRows`] is a step, with coefficients of
    /// [`AngleSet::cells`]; docs/builders/architecture.md has its equations.
    fn sweep_planes(
        &mut self,
        (side, ordinate): (usize, usize),
        stencil: &UpwindStencil,
        incident: &BoundaryCondition,
    ) {
        let (planes, channel) = (self.planes, self.channel);
        let row = planes.row();
        let rim = |plane: i32| Rim { planes: &planes, plane, channel, ordinate };
        let before_first = if stencil.backwards < 0 { -1 } else { planes.count[0] as i32 };
        incident.fill(rim(before_first), &mut self.before);
        incident.fill(rim(0), &mut self.behind);
        let here = row + 1;
        let first = [0, 1, 2, 3].map(|tap| planes.shifted(here, stencil.step(tap)));
        for number in 0..planes.count[0] {
            let plane = if stencil.backwards < 0 { number } else { planes.count[0] - 1 - number };
            let nodes = plane * planes.stride[0]..;
            if incident.varies() {
                incident.fill(rim(plane as i32), &mut self.behind);
            }
            vectorized(StepRows {
                shares: stencil.shares,
                before: &self.before,
                first,
                behind: &mut self.behind,
                here,
                rows: planes.count[1],
                row,
                columns: planes.count[2],
                through: &self.own.through[nodes.clone()],
                mean: &self.own.mean[nodes.clone()],
                added: &self.own.added[side][nodes.clone()],
                added_within: &self.own.added_within[side][nodes.clone()],
                radiance: &mut self.own.radiance[side][nodes],
                stride: planes.stride[1],
            });
            self.past_cut_links((side, plane), stencil);
            std::mem::swap(&mut self.before, &mut self.behind);
        }
    }

    /// Radiance at nodes with cut links: a wall's radiance enters by its links instead of the neighbour's.
    fn past_cut_links(&mut self, (side, plane): (usize, usize), stencil: &UpwindStencil) {
        let planes = self.planes;
        let steps = [0, 1, 2, 3].map(|tap| stencil.step(tap));
        let links = steps.map(|step| planes.link(step));
        for &Cut { links: seen, node, here, room } in &self.cut[plane] {
            let shares = stencil.shares_of_cut(room);
            let mut entering = 0.0;
            for tap in 0..4 {
                // A share of 0 may point beyond the rim.
                if shares[tap] > 0.0 {
                    entering += shares[tap]
                        * match seen.wall_at(links[tap]) {
                            Some(patch) => self.walls[patch],
                            None => self.before[planes.shifted(here, steps[tap])],
                        };
                }
            }
            self.own.radiance[side][node] =
                entering * self.own.mean[node] + self.own.added_within[side][node];
            self.behind[here] = entering * self.own.through[node] + self.own.added[side][node];
            self.own.at_walls[side][node] = self.behind[here];
        }
    }
}

/// Interpolates values of nodes at places.
fn means(of_nodes: &[f32], places: &[Corners]) -> Vec<f32> {
    let mean = |corners: &Corners| corners.iter().map(|(node, weight)| weight as f32 * of_nodes[node]).sum();
    places.iter().map(mean).collect()
}

/// Nodes with cut links, by plane.
fn cut_by_plane<'a>((grid, walls): (&Grid, &'a Walls), layout: Layout, planes: &Planes) -> Vec<Vec<Cut<'a>>> {
    let mut cut: Vec<Vec<Cut>> = (0..planes.count[0]).map(|_| Vec::new()).collect();
    for links in &walls.nodes {
        let place = grid.cell_of(links.node);
        let [plane, row, column] = planes.axes.map(|axis| place[axis]);
        let here = (row + 1) * planes.row() + column + 1;
        let room = [1, 2].map(|which| links.room(planes.axes[which]));
        cut[plane].push(Cut { links, node: layout.node(links.node), here, room });
    }
    cut
}

/// Pairs of an ordinate whose main axis is `axis`, in its positive direction, and its opposite.
fn pairs(quadrature: &Quadrature, axis: usize) -> Vec<Pair> {
    let forwards =
        |ordinate: &Ordinate| main_axis(ordinate.direction) == axis && ordinate.direction[axis] > 0.0;
    let numbered = quadrature.iter().enumerate().filter(|(_, ordinate)| forwards(ordinate));
    numbered
        .map(|(number, &ordinate)| Pair {
            ordinate,
            numbers: [number, quadrature.nearest(-ordinate.direction)],
        })
        .collect()
}

/// Axis of the largest component of a direction.
fn main_axis(direction: DVec3) -> usize {
    let along = direction.abs();
    // Equal components differ by rounding.
    let most = along.max_element() - 1e-9;
    (0..3).rev().find(|axis| along[*axis] >= most).expect("one is the largest")
}
