//! State of a path. It holds a snapshot, settings of ray tracing and the light to follow; each leg reads
//! these, draws random numbers and uses the thread's scratch memory. Invariant: a path belongs to one thread.

use super::branches::Branches;
use super::learned::{Learned, Noted};
use super::shared_walks::Roots;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::fog::LitSegments;
use crate::indirect::Indirect;
use crate::math::{Ray, Sampler};
use crate::scene::Bounces;
use crate::snapshot::{FrozenLight, SeenRay, Snapshot, SurfacePoint};
use glam::DVec3;
use std::sync::Arc;

/// Places of the shadow rays.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum MarchSteps {
    /// The image plane is moved by `step_m` at a time, to `depth_m`, both along the view axis, metres.
    Planes {
        /// Depth that the plane is moved to.
        depth_m: f64,
        /// Step of the plane.
        step_m: f64,
    },
    /// Number of equal steps over the foggy part of the ray, a shadow ray in the middle of each.
    Count(u32),
    /// Ray marching with all steps of a ray shifted by the same random part of a step, which turns banding
    /// into noise (Pauly, Kollig & Keller 2000, "Metropolis Light Transport for Participating Media").
    Jittered(u32),
}

/// Method for light that fog scatters into a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VolumeMethod {
    /// Exact visibility intervals from geometry, closed forms and quadrature on smooth pieces.
    Segments,
    /// A shadow ray at each step.
    March(MarchSteps),
    /// Shadow rays at points spread evenly over the angle seen from the light (Kulla & Fajardo 2012).
    Equiangular {
        /// Points a ray and light, at least 1.
        points: u32,
    },
    /// As `Segments`, with indirect light by random walks of at most so many bounces.
    Paths(Bounces),
}

/// Settings by which rays are followed.
#[derive(Clone, Copy)]
pub struct Transport<'a> {
    /// Method for light that fog scatters.
    pub volume: VolumeMethod,
    /// Maximum number of reflections by mirrors.
    pub mirror_depth: u32,
    /// Indirect light at surfaces and in fog; may include that of the sky.
    pub indirect: Option<&'a Indirect>,
    /// Whether [`Sample::surface`](super::Sample::surface) is needed.
    pub features: bool,
}

/// Memory that rays of one thread share.
#[derive(Default)]
pub struct Scratch {
    pub(super) lit: LitSegments,
    pub(super) lights: Vec<FrozenLight>,
    /// Beams that guide random walks; `None` until they are learned.
    pub(super) learned: Option<Arc<Learned>>,
    /// Sunlit points that walks met until then.
    pub(super) noted: Noted,
    /// Whether the next walks of surfaces and of fog are shared.
    pub(super) shares_on_surface: bool,
    pub(super) shares_in_fog: bool,
    /// Walks that are shared.
    pub(super) roots: Roots,
}

impl Scratch {
    /// Memory of walks with beams that were learned before.
    pub fn with_learned(learned: Option<Arc<Learned>>) -> Self {
        Self { learned, ..Self::default() }
    }

    /// Takes the points that walks met since the last call; empty once beams are learned.
    pub fn take_noted(&mut self) -> Noted {
        std::mem::take(&mut self.noted)
    }

    /// Has the walks of the next camera ray shared, or not.
    pub fn share_walks(&mut self, shares: bool) {
        (self.shares_on_surface, self.shares_in_fog) = (shares, shares);
    }

    /// Walks of the last camera ray that are shared.
    pub fn take_roots(&mut self) -> Roots {
        self.share_walks(false);
        std::mem::take(&mut self.roots)
    }
}

/// Light that a path follows: a picture may be a sum with one picture for each light.
#[derive(Clone, Copy)]
pub(super) struct Illumination<'a> {
    pub(super) lights: &'a [FrozenLight],
    /// Whether it includes the rest: emission, the background and indirect light.
    pub(super) has_rest: bool,
    /// Whether it includes light of the sky.
    pub(super) sky: bool,
    /// Whether it is seen in a specular reflection. A second such reflection has the blur of the grid.
    pub(super) is_in_specular: bool,
    /// Whether light that reaches the eye after one scattering is left out.
    pub(super) indirect_alone: bool,
    /// Walks that branch off the camera ray.
    pub(super) branches: Branches,
}

impl Illumination<'_> {
    /// Emission of a surface; 0 unless the illumination includes the rest.
    pub(super) fn emitted(&self, point: &SurfacePoint) -> Rgb {
        if self.has_rest { point.emission } else { Rgb::ZERO }
    }

    /// Radiance of the background in a direction; 0 unless the illumination includes the rest.
    pub(super) fn background(&self, snapshot: &Snapshot, direction: DVec3, from: Start) -> Rgb {
        match from {
            _ if !self.has_rest => Rgb::ZERO,
            Start::Camera => snapshot.seen_beyond(direction),
            Start::Surface(_) | Start::Specular(_) => snapshot.radiance_beyond(direction),
        }
    }
}

#[derive(Clone, Copy)]
pub(super) enum Start {
    /// The eye, whose clipping planes hide surfaces.
    Camera,
    /// A mirror.
    Surface(PrimitiveId),
    /// A surface with a specular reflection, which samples the background by a ray of its own.
    Specular(PrimitiveId),
}

impl Start {
    /// Triangle that a ray leaves.
    pub(super) fn leaving(self) -> Option<PrimitiveId> {
        match self {
            Self::Camera => None,
            Self::Surface(primitive) | Self::Specular(primitive) => Some(primitive),
        }
    }

    /// Whether rays from this start see a triangle.
    pub(super) fn sees(self, snapshot: &Snapshot, primitive: PrimitiveId) -> bool {
        !matches!(self, Self::Camera) || snapshot.is_seen(primitive)
    }

    /// Whether they see a hole in the picture in place of a triangle.
    pub(super) fn sees_hole(self, snapshot: &Snapshot, primitive: PrimitiveId) -> bool {
        matches!(self, Self::Camera) && snapshot.is_holdout(primitive)
    }
}

/// A path that is being traced.
pub(super) struct Path<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) transport: &'a Transport<'a>,
    pub(super) light: Illumination<'a>,
    pub(super) sampler: &'a mut Sampler,
    pub(super) scratch: &'a mut Scratch,
}

impl<'a> Path<'a> {
    /// Fog on a ray from a start, if it was computed for all rays from there.
    pub(super) fn seen_fog<'r>(&self, ray: &'r Ray, from: Start) -> Option<SeenRay<'r>>
    where
        'a: 'r,
    {
        let is_known = matches!(from, Start::Camera) && self.transport.volume == VolumeMethod::Segments;
        self.snapshot.seen_fog().filter(|_| is_known).map(|fog| fog.along(ray))
    }

    /// Optical depth of fog from the origin of a ray to the sky.
    pub(super) fn depth_to_sky(&self, to_sky: &Ray) -> Rgb {
        let medium = &self.snapshot.medium;
        match self.transport.volume {
            VolumeMethod::Segments => medium.optical_depth_to_sky(to_sky),
            _ => medium.optical_depth(to_sky.origin, to_sky.direction, f64::INFINITY),
        }
    }

    /// Transmittance of fog from the start of a ray to a distance in metres.
    pub(super) fn through_fog(&self, (ray, from): (&Ray, Start), distance: f64) -> Rgb {
        let walked = || self.snapshot.medium.transmittance(ray.origin, ray.direction, distance);
        self.seen_fog(ray, from).map_or_else(walked, |seen| seen.transmittance(distance))
    }

    /// Indirect light of the grid, if there is one and the illumination includes the rest.
    pub(super) fn indirect(&self) -> Option<&'a Indirect> {
        self.transport.indirect.filter(|_| self.light.has_rest)
    }

    /// Maximum number of scatterings of random walks; `None` if indirect light is not by walks.
    pub(super) fn walks(&self) -> Option<Bounces> {
        match self.transport.volume {
            VolumeMethod::Paths(bounces) if bounces != Bounces::NONE => Some(bounces),
            _ => None,
        }
    }

    /// Whether light of the sky is sampled by rays in random directions, as direct light. It is not if
    /// indirect light includes it, on a grid or by walks. A grid leaves out a sky that holds a sun: such a
    /// sky has direct light alone.
    pub(super) fn samples_sky(&self) -> bool {
        self.light.sky && !self.transport.indirect.is_some_and(Indirect::has_sky) && !self.walks_have_sky()
    }

    /// Whether random walks include light of the sky.
    pub(super) fn walks_have_sky(&self) -> bool {
        self.walks().is_some() && self.snapshot.sky.is_some_and(|sky| !sky.has_sun())
    }
}
