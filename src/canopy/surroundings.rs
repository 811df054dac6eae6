//! Surroundings for light between orders, in world space: small parts as surfels, large ones as walls. In
//! goes a snapshot, out come both and their bounds. Invariant: each visible triangle belongs to one of the
//! two.

pub(crate) mod emissive;
mod placed_part;
pub(crate) mod wide;

use self::placed_part::PlacedPart;
use super::recollision::bent;
use super::sheets::spread;
use super::surface_optics::optics_at;
use super::surfels::{Surfel, Surfels};
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::{kronecker, large_list};
use crate::ordinates::occluders::Triangle;
use crate::ordinates::surface_optics::{MeanOptics, SurfaceOptics};
use crate::snapshot::{DrawnMesh, PartPlace, Snapshot};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// A triangle of a part that is larger than a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallTriangle {
    pub(crate) triangle: Triangle,
    pub(crate) primitive: PrimitiveId,
}

/// Length in cells up to which a part has the mean optics of its look; longer parts have those of each place.
const SMALL_CELLS: f64 = 1.0;

/// A small part with two sides.
pub(crate) struct Leaf {
    /// Number of the mesh, and of the part in it.
    pub(crate) mesh: u32,
    pub(crate) part: u32,
    /// Position of its centre, in world space.
    pub(crate) position: DVec3,
    pub(crate) normal: DVec3,
    /// Area of one side times coverage, m^2.
    pub(crate) area_m2: f64,
    /// Share of light from all sides that the leaf itself does not shade.
    pub(crate) exposed: f64,
    /// Mean optics of all parts with its look.
    pub(crate) optics: Arc<SurfaceOptics>,
}

impl Leaf {
    /// The leaf without emission; `None` if it does not emit.
    pub(crate) fn dark(&self) -> Option<Self> {
        let optics = || Arc::new(SurfaceOptics { emission: Rgb::ZERO, ..*self.optics });
        (self.optics.emission != Rgb::ZERO).then(|| Self { optics: optics(), ..*self })
    }
}

/// Minimum share of a leaf's area that faces one way; a body faces all ways.
const FLAT: f64 = 0.5;

/// Number of leaves that are computed before results are collected.
const AT_ONCE: usize = 1 << 14;

/// Number of points of a part with a unique look, and of all of them together.
const POINTS: usize = 64;
const MOST_POINTS: usize = 400_000;
const FEWEST_POINTS: usize = 8;

/// The visible parts of a snapshot.
pub(crate) struct Surroundings<'a> {
    snapshot: &'a Snapshot<'a>,
    parts: Vec<PlacedPart<'a>>,
    /// Mean of the parts that look alike, by their looks, once somebody asks.
    means: Vec<OnceLock<SurfaceOptics>>,
}

impl<'a> Surroundings<'a> {
    pub(crate) fn of(snapshot: &'a Snapshot) -> Self {
        let (mut first_looks, mut looks) = (HashMap::new(), 0);
        let placed = |mesh_number: usize| {
            let mesh = snapshot.mesh(mesh_number);
            let first_looks = *first_looks.entry((mesh.looks(), mesh.is_blended)).or_insert_with(|| {
                looks += mesh.parts().len();
                looks - mesh.parts().len()
            });
            let axes = mesh.relative_from_mesh.matrix3;
            let scale = DVec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
            mesh.parts().iter().enumerate().map(move |(number, part)| {
                let mut sides = ((part.high - part.low) * scale).to_array();
                sides.sort_by(f64::total_cmp);
                let [thickness_m, width_m, length_m] = sides;
                PlacedPart {
                    mesh_number: mesh_number as u32,
                    part,
                    number: number as u32,
                    looks: (first_looks + number) as u32,
                    thickness_m,
                    width_m,
                    length_m,
                    is_blended: mesh.is_blended,
                    is_plain: false,
                }
            })
        };
        // Most meshes are one leaf, and so one part.
        let mut parts = large_list(snapshot.mesh_count());
        parts.extend((0..snapshot.mesh_count()).flat_map(placed));
        let means = (0..looks).map(|_| OnceLock::new()).collect();
        Self { snapshot, parts, means }
    }

    fn mesh(&self, part: &PlacedPart) -> DrawnMesh<'a> {
        self.snapshot.mesh(part.mesh_number as usize)
    }

    /// Width of leaves: the mean by area over all parts narrower than `widest_m`; 0 if there are fewer than
    /// `few`.
    pub(crate) fn leaf_width_m(&self, widest_m: f64, few: usize) -> f64 {
        let leaves = self.parts.iter().filter(|part| !part.stands_alone(widest_m));
        if leaves.clone().count() < few {
            return 0.0;
        }
        let (weighted, all) = leaves.fold((0.0, 0.0), |(weighted, all), leaf| {
            let area = (leaf.part.high - leaf.part.low).length_squared();
            (weighted + area * leaf.width_m, all + area)
        });
        if all > 0.0 { weighted / all } else { 0.0 }
    }

    /// Surfels of small parts: those narrower than `width_m`. Short closed ones may emit apart.
    pub(crate) fn surfels(&self, width_m: f64, cell_m: f64, emit_apart: bool) -> Surfels<'_> {
        let leaves: Vec<&PlacedPart> = self.parts.iter().filter(|part| !part.is_wall(width_m)).collect();
        self.find_means(leaves.iter().copied());
        let is_small = move |leaf: &PlacedPart| leaf.length_m < SMALL_CELLS * cell_m;
        // By look: indices of the mean's optics, and of those of the first place.
        let [mut means, mut places, mut sheets] = [(); 3].map(|()| vec![None; self.means.len()]);
        let mut optics = Vec::new();
        for leaf in &leaves {
            let looks = leaf.looks as usize;
            if means[looks].is_none() {
                means[looks] = Some(optics.len() as u32);
                optics.push(bent(&self.mean(leaf), leaf.exposed()));
            }
            if sheets[looks].is_none() && leaf.is_large(width_m) {
                sheets[looks] = Some(optics.len() as u32);
                optics.push(spread(&self.mean(leaf)));
            }
            if places[looks].is_none() && !is_small(leaf) && !leaf.is_large(width_m) {
                places[looks] = Some(optics.len() as u32);
                optics.extend(self.optics_of_places(leaf).map(|place| bent(&place, leaf.exposed())));
            }
        }
        let (optics, count): (Arc<[SurfaceOptics]>, _) = (optics.into(), leaves.len());
        let known = Arc::clone(&optics);
        let surfels_of = move |leaf: &&PlacedPart| {
            let looks = leaf.looks as usize;
            if leaf.is_large(width_m) {
                return self.sheet(leaf, (sheets[looks].unwrap_or_default(), &known), cell_m);
            }
            let mean = means[looks].unwrap_or_default();
            let is_small = is_small(leaf);
            let first_place = places[looks].unwrap_or_default();
            let optics_of = |number: u32| if is_small { mean } else { first_place + number };
            let mut surfels = self.surfels_of(leaf, is_small, (optics_of, &known));
            let is_apart = emit_apart && self.emits_apart(leaf, (width_m, cell_m));
            let emits = if is_apart { 0.0 } else { leaf.emits(cell_m) as f32 };
            surfels.iter_mut().for_each(|surfel| surfel.emits = emits);
            surfels
        };
        let of_chunk = move |chunk: usize| {
            let by_leaf: Vec<Vec<Surfel>> =
                leaves.chunks(AT_ONCE).nth(chunk)?.par_iter().map(&surfels_of).collect();
            let mut surfels = large_list(by_leaf.iter().map(Vec::len).sum());
            surfels.extend(by_leaf.into_iter().flatten());
            Some(surfels)
        };
        Surfels::new(count, optics, Box::new(of_chunk))
    }

    /// Surfels at the places of a part, with the optics of each by its number.
    fn surfels_of(
        &self,
        leaf: &PlacedPart,
        is_small: bool,
        (optics_of, known): (impl Fn(u32) -> u32, &[SurfaceOptics]),
    ) -> Vec<Surfel> {
        let chosen = if is_small { &leaf.part.few_places } else { &leaf.part.places };
        let surfel =
            |(place, number): (&PartPlace, u32)| self.surfel(leaf, place, (optics_of(number), known));
        let mut surfels: Vec<Surfel> = chosen.iter().zip(0..).filter_map(surfel).collect();
        if is_small {
            // One position for all surfels of a part, where its light is gathered.
            let middle = middle(surfels.iter().map(|surfel| (surfel.area, surfel.position)));
            surfels.iter_mut().for_each(|surfel| surfel.position = middle);
        }
        surfels
    }

    /// Surfels of a large transparent part: all of its triangles, in pieces no longer than a cell.
    fn sheet(&self, leaf: &PlacedPart, optics: (u32, &[SurfaceOptics]), cell_m: f64) -> Vec<Surfel> {
        const MOST_PIECES: f64 = 64.0;
        let (mesh, mut surfels) = (self.mesh(leaf), Vec::new());
        for &triangle in &leaf.part.triangles {
            let place = PartPlace { triangle, share: 1.0, area: 1.0 };
            let Some((primitive, whole)) = mesh.primitive(triangle).zip(self.surfel(leaf, &place, optics))
            else {
                continue;
            };
            let [a, b, c] = self.world_corners(primitive);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let count = (longest / cell_m).ceil().clamp(1.0, MOST_PIECES);
            for (v, w) in middles(count) {
                let position = a + v * (b - a) + w * (c - a);
                // Parts that shade each other lie in cells of their own.
                let (area, exposed) = (whole.area / (count * count), 1.0);
                surfels.push(Surfel { position, area, exposed, ..whole });
            }
        }
        surfels
    }

    /// Parts with two sides that are no longer than a cell, in the order of their meshes.
    pub(crate) fn leaves(&self, cell_m: f64) -> Vec<Leaf> {
        let is_small = |part: &&PlacedPart| part.length_m < SMALL_CELLS * cell_m && !part.part.is_closed;
        self.find_means(self.parts.iter().filter(is_small));
        let means: Vec<Option<Arc<SurfaceOptics>>> =
            self.means.iter().map(|mean| mean.get().map(|mean| Arc::new(*mean))).collect();
        let mut all = large_list(self.parts.iter().filter(is_small).count());
        for parts in self.parts.chunks(AT_ONCE) {
            let small = parts.par_iter().filter(is_small);
            let leaves = small.filter_map(|part| self.leaf(part, means[part.looks as usize].as_ref()?));
            all.extend(leaves.collect::<Vec<_>>());
        }
        all
    }

    fn leaf(&self, part: &PlacedPart, optics: &Arc<SurfaceOptics>) -> Option<Leaf> {
        let (mut places, mut facing, mut all) = (Vec::with_capacity(2), DVec3::ZERO, 0.0);
        for place in &part.part.few_places {
            let [a, b, c] = self.world_corners(self.mesh(part).primitive(place.triangle)?);
            let area_normal = place.share * 0.5 * (b - a).cross(c - a);
            let area = area_normal.length();
            places.push((area, (a + b + c) / 3.0));
            facing += area_normal;
            all += area;
        }
        let is_flat = all > 0.0 && facing.length() > FLAT * all;
        is_flat.then(|| Leaf {
            mesh: part.mesh_number,
            part: part.number,
            position: middle(places.into_iter()),
            normal: facing.normalize(),
            area_m2: all * optics.cover,
            exposed: part.exposed(),
            optics: Arc::clone(optics),
        })
    }

    fn find_means<'p>(&self, parts: impl Iterator<Item = &'p PlacedPart<'a>>)
    where
        'a: 'p,
    {
        let mut is_known: Vec<bool> = self.means.iter().map(|mean| mean.get().is_some()).collect();
        let unknown = parts.filter(|part| !std::mem::replace(&mut is_known[part.looks as usize], true));
        unknown.collect::<Vec<_>>().into_par_iter().for_each(|part| {
            self.mean(part);
        });
    }

    /// Mean of all parts that look as one does.
    fn mean(&self, part: &PlacedPart) -> SurfaceOptics {
        let points = points_of_each(self.means.len());
        *self.means[part.looks as usize].get_or_init(|| self.mean_optics(part, points))
    }

    /// Mean optics at evenly spaced points of a part, as a texture differs from point to point.
    fn mean_optics(&self, leaf: &PlacedPart, points: usize) -> SurfaceOptics {
        let corners_of = |triangle: u32| Some(self.world_corners(self.mesh(leaf).primitive(triangle)?));
        let area_of = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
        let triangles = || {
            leaf.part.triangles.iter().filter_map(|&triangle| {
                let corners = corners_of(triangle)?;
                Some((self.mesh(leaf).primitive(triangle)?, corners, area_of(corners)))
            })
        };
        let step = triangles().map(|(.., area)| area).sum::<f64>() / points as f64;
        let (mut mean, mut so_far, mut number) = (MeanOptics::default(), 0.0, 0);
        for (primitive, [a, b, c], area) in triangles() {
            so_far += area;
            while number < points && (number as f64 + 0.5) * step < so_far {
                let (u, v) = (kronecker(0.5, number).sqrt(), kronecker(0.5, 7 * number));
                let position = (1.0 - u) * a + u * (1.0 - v) * b + u * v * c;
                let normal = (b - a).cross(c - a).normalize_or_zero();
                mean.add(step, &optics_at(self.snapshot, primitive, position, normal));
                number += 1;
            }
        }
        mean.mean()
    }

    fn optics_of_places(&self, leaf: &PlacedPart) -> impl Iterator<Item = SurfaceOptics> {
        leaf.part.places.iter().map(|place| {
            let Some(primitive) = self.mesh(leaf).primitive(place.triangle) else {
                return SurfaceOptics::default();
            };
            let [a, b, c] = self.world_corners(primitive);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            optics_at(self.snapshot, primitive, (a + b + c) / 3.0, normal)
        })
    }

    /// Triangles of all parts that are walls.
    pub(crate) fn walls(&self, width_m: f64) -> Vec<WallTriangle> {
        let walls = self.parts.iter().filter(|part| part.is_wall(width_m));
        let triangle = |wall: &PlacedPart<'a>, triangle: u32| {
            let primitive = self.mesh(wall).primitive(triangle)?;
            let corners = self.world_corners(primitive);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            Some(WallTriangle { triangle: Triangle { corners, normal }, primitive })
        };
        walls
            .flat_map(|wall| wall.part.triangles.iter().filter_map(move |&number| triangle(wall, number)))
            .collect()
    }

    fn world_corners(&self, primitive: PrimitiveId) -> [DVec3; 3] {
        self.snapshot.corners(primitive).map(|corner| self.snapshot.world_from_relative(corner))
    }

    fn surfel(
        &self,
        leaf: &PlacedPart,
        place: &PartPlace,
        (number, optics): (u32, &[SurfaceOptics]),
    ) -> Option<Surfel> {
        let primitive = self.mesh(leaf).primitive(place.triangle)?;
        let [a, b, c] = self.world_corners(primitive);
        let area_normal = 0.5 * (b - a).cross(c - a);
        let normal = area_normal.try_normalize()?;
        let area = place.share * area_normal.length() * optics[number as usize].cover;
        let (position, exposed) = ((a + b + c) / 3.0, leaf.part.exposed as f32);
        Some(Surfel { position, normal, area, exposed, emits: 1.0, optics: number })
    }
}

/// Number of sampled points of a part, for so many looks. It is a power of two, so that colours hardly change
/// as it does.
fn points_of_each(looks: usize) -> usize {
    let points = (MOST_POINTS / looks.max(1)).clamp(FEWEST_POINTS, POINTS);
    1 << points.ilog2()
}

/// Mean of places by their areas.
fn middle(places: impl Iterator<Item = (f64, DVec3)>) -> DVec3 {
    let (sum, all) =
        places.fold((DVec3::ZERO, 0.0), |(sum, all), (area, place)| (sum + area * place, all + area));
    if all > 0.0 { sum / all } else { sum }
}

/// Centres of the equal triangles from dividing each side of a triangle in `count`, as weights of its second
/// and third corner.
fn middles(count: f64) -> impl Iterator<Item = (f64, f64)> {
    let side = count as usize;
    let middle =
        move |i: usize, j: usize, third: f64| ((i as f64 + third) / count, (j as f64 + third) / count);
    (0..side).flat_map(move |i| {
        let upright = (0..side - i).map(move |j| middle(i, j, 1.0 / 3.0));
        let turned = (0..(side - i).saturating_sub(1)).map(move |j| middle(i, j, 2.0 / 3.0));
        upright.chain(turned)
    })
}

#[cfg(test)]
mod tests {
    use super::middles;

    #[test]
    fn pieces_share_out_a_triangle() {
        for count in [1.0, 2.0, 5.0] {
            let (number, v, w) = middles(count)
                .fold((0, 0.0, 0.0), |(number, sum_v, sum_w), (v, w)| (number + 1, sum_v + v, sum_w + w));
            let all = count * count;
            assert_eq!(f64::from(number), all);
            assert!((v / all - 1.0 / 3.0).abs() < 1e-12 && (w / all - 1.0 / 3.0).abs() < 1e-12, "{v} {w}");
        }
    }
}
