//! Fog from OpenVDB grids. In go files, out come voxels by time. Invariant: grids with negative densities, or
//! with a background other than 0, are refused before they are used.

mod advection;
mod leaves;
mod parts;
mod velocities;

use super::{FrameRate, Track};
use crate::color::Rgb;
use crate::description::vdb::{Grid, GridFile, GridFiles};
use crate::math::{LitVoxels, Recent, Voxels};
use glam::DAffine3;
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;
use velocities::Velocities;

/// Default name of the density grid.
pub(super) const USUAL_GRID: &str = "density";
/// Cached frames: those around a time, and the interpolated one.
const KEPT: usize = 3;

/// Fog from the grids of a file, or of a file a frame.
#[derive(Clone, Debug)]
pub struct GridFrames {
    /// Path of the file; for a sequence, with its placeholder.
    pub path: PathBuf,
    /// Names of the grids that are used.
    pub names: GridNames,
    /// Frames by time, at least one.
    pub frames: Vec<GridFrame>,
    /// Emission where its grid is 1, W m^-3 sr^-1.
    pub emission: Track<Rgb>,
    /// Name of a used grid that several grids of the file have.
    pub shared_name: Option<String>,
    between: Between,
    kept: Recent<Asked, Option<Arc<FogVoxels>>>,
}

/// State between two files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// Voxels of the nearer file.
    Held,
    /// Advected from both files by their velocities.
    Carried,
    /// Advected, except that velocities are too large, so that the nearer file is used.
    CarriedTooFar,
}

/// Names of grids.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridNames {
    /// Grid that multiplies the fog's density.
    pub density: String,
    /// Grid of colours that multiply its albedo.
    pub albedo: Option<String>,
    /// Grid of emission.
    pub emission: Option<String>,
    /// Temperature in kelvin where that grid is 1, for blackbody emission.
    pub kelvin: Option<f64>,
    /// Whether blackbody emission is that of Blender's Principled Volume.
    pub is_principled: bool,
}

/// Grids at a time.
#[derive(Clone, Debug)]
pub struct GridFrame {
    /// Time of the grids.
    pub time_s: f64,
    source: Source,
}

#[derive(Clone, Debug)]
enum Source {
    /// Voxels in memory.
    Made(Arc<FogVoxels>),
    /// File that is decoded on demand, as a sequence may exceed memory.
    File(Arc<GridFile>),
}

/// Fog from voxels at one time.
#[derive(Debug, Default)]
pub struct FogVoxels {
    /// Transform from voxel coordinates, which are integers at centres.
    pub shape_from_voxel: DAffine3,
    /// Overlapping volumes, whose sum is the fog; one, unless albedo varies by voxel.
    pub parts: Vec<FogPart>,
    /// Transform from the emission grid's own coordinates.
    pub shape_from_emission: DAffine3,
    /// Emission: voxels with their factors.
    pub emission: Vec<(Rgb, Arc<Voxels>)>,
    /// Velocities in the shape's space.
    velocities: Option<Arc<Velocities>>,
}

/// Fog of a single albedo.
#[derive(Clone, Debug)]
pub struct FogPart {
    /// Its share of extinction, by channel.
    pub extinction: Rgb,
    /// Its albedo, relative to the fog's.
    pub albedo: Rgb,
    /// Its densities.
    pub voxels: Arc<LitVoxels>,
}

/// Frame before a time, and the bits of the fraction after it; 0 is the frame itself.
type Asked = (usize, u64);

impl GridNames {
    /// Name of several grids, the first of which is used.
    fn shared(&self, grids: &[Grid]) -> Option<String> {
        let names = [Some(&self.density), self.albedo.as_ref(), self.emission.as_ref()];
        let is_shared = |name: &&String| grids.iter().filter(|grid| grid.name == **name).count() > 1;
        names.into_iter().flatten().find(is_shared).cloned()
    }
}

impl GridFrame {
    /// Frame of voxels in memory.
    pub fn made(time_s: f64, voxels: FogVoxels) -> Self {
        Self { time_s, source: Source::Made(Arc::new(voxels)) }
    }
}

impl FogVoxels {
    /// Fog of a single albedo without emission.
    pub fn plain(shape_from_voxel: DAffine3, voxels: Voxels) -> Self {
        let part = FogPart { extinction: Rgb::ONE, albedo: Rgb::ONE, voxels: Arc::new(voxels.into()) };
        Self { shape_from_voxel, parts: vec![part], ..Self::default() }
    }
}

impl GridFrames {
    /// Frames of grids with one name, without emission.
    pub fn new(path: PathBuf, density: &str, frames: Vec<GridFrame>) -> Self {
        let names = GridNames { density: density.to_owned(), ..GridNames::default() };
        let emission = Track::from(Rgb::ZERO);
        let (between, kept) = (Between::Held, Recent::default());
        Self { path, names, frames, emission, shared_name: None, between, kept }
    }

    /// Grids at a time: between files advected from both by their velocities, or without velocities those of
    /// the nearer one. `None` if it is empty.
    pub fn at(&self, time_s: f64) -> Option<Arc<FogVoxels>> {
        let after = self.frames.partition_point(|frame| frame.time_s <= time_s);
        let before = after.saturating_sub(1);
        let (Some(from), Some(to)) = (self.frames.get(before), self.frames.get(after)) else {
            return self.frame(before);
        };
        let times_s = [from.time_s, to.time_s];
        let nearer = if 2.0 * time_s < times_s[0] + times_s[1] { before } else { after };
        if !self.is_carried() || time_s <= from.time_s {
            return self.frame(nearer);
        }
        self.kept.of((before, time_s.to_bits()), KEPT, || {
            let [earlier, later] = [self.frame(before)?, self.frame(after)?];
            let between = advection::between([&earlier, &later], times_s, time_s);
            between.map(Arc::new).or_else(|| self.frame(nearer))
        })
    }

    /// Whether anything is advected between its files.
    pub fn is_carried(&self) -> bool {
        self.between != Between::Held
    }

    /// State between its files.
    pub fn between(&self) -> Between {
        self.between
    }

    fn frame(&self, number: usize) -> Option<Arc<FogVoxels>> {
        match &self.frames.get(number)?.source {
            Source::Made(voxels) => Some(Arc::clone(voxels)),
            Source::File(file) => self
                .kept
                .of((number, 0), KEPT, || parts::fog_voxels(&file.grids(), &self.names).ok().map(Arc::new)),
        }
    }
}

/// Reason why a grid is refused.
pub(super) struct Refused {
    pub(super) found: String,
    pub(super) expected: String,
    pub(super) remedy: &'static str,
}

/// Grids of these names in files, with their emission; sequences have a frame rate.
pub(super) fn grid_frames(
    files: &GridFiles,
    names: GridNames,
    emission: Track<Rgb>,
    frame_rate: FrameRate,
) -> Result<GridFrames, Refused> {
    let is_sequence = files.frames.len() > 1;
    let frames = files.frames.par_iter().enumerate().map(|(index, file)| {
        let number = files.first_frame + index as i64;
        let of_frame = || if is_sequence { format!(" (frame {number})") } else { String::new() };
        let in_file = |found: String| format!("{}{}: {found}", files.path.display(), of_frame());
        let grids = file.grids();
        let voxels = parts::fog_voxels(&grids, &names)
            .map_err(|refused| Refused { found: in_file(refused.found), ..refused })?;
        let most = voxels.velocities.as_ref().map(|of| of.most(voxels.shape_from_voxel.matrix3.inverse()));
        let source =
            if is_sequence { Source::File(Arc::clone(file)) } else { Source::Made(Arc::new(voxels)) };
        Ok((GridFrame { time_s: frame_rate.seconds(number as f64), source }, most, names.shared(&grids)))
    });
    // The first of several errors.
    let frames: Vec<_> = frames.collect();
    let frames = frames.into_iter().collect::<Result<Vec<_>, _>>()?;
    let most_a_second =
        frames.iter().map(|(_, most, _)| *most).try_fold(0.0, |all, most| Some(most?.max(all)));
    let between = match most_a_second.filter(|_| is_sequence) {
        None => Between::Held,
        Some(most) if most * frame_rate.seconds(1.0) > advection::FARTHEST => Between::CarriedTooFar,
        Some(_) => Between::Carried,
    };
    let shared_name = frames.iter().find_map(|(.., shared)| shared.clone());
    Ok(GridFrames {
        path: files.path.clone(),
        shared_name,
        names,
        frames: frames.into_iter().map(|(frame, ..)| frame).collect(),
        emission,
        between,
        kept: Recent::default(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_counts_is_told_if_several_grids_have_it() {
        let grid = |name: &str| Grid {
            name: name.to_owned(),
            kind: String::new(),
            floats: None,
            vectors: None,
            is_staggered: false,
        };
        let grids = ["density", "heat", "heat", "density"].map(grid);
        let names = GridFrames::new(PathBuf::new(), "density", Vec::new()).names;
        let hot = GridNames {
            density: String::from("smoke"),
            emission: Some(String::from("heat")),
            ..names.clone()
        };
        assert_eq!(names.shared(&grids).as_deref(), Some("density"));
        assert_eq!(hot.shared(&grids).as_deref(), Some("heat"));
        assert_eq!(names.shared(&grids[1..]), None);
    }
}
