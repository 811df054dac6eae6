//! State of a path: a snapshot, a way to follow rays and the light that is wanted. Every leg of the path
//! reads them, draws random numbers and uses memory that the thread keeps. Invariant: a path is one
//! thread's.

use super::branches::Branches;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::fog::LitSegments;
use crate::indirect::Indirect;
use crate::math::{Ray, Sampler};
use crate::scene::Bounces;
use crate::snapshot::{FrozenLight, SeenRay, Snapshot, SurfacePoint};
use glam::DVec3;

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
    /// Ray marching with all shadow rays moved by one random part of a step: what is banding above is
    /// noise here (Pauly, Kollig & Keller 2000, "Metropolis Light Transport for Participating Media").
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
    /// As `Segments`, and indirect light by random walks with so many bounces.
    Paths(Bounces),
}

/// Settings by which rays are followed.
#[derive(Clone, Copy)]
pub struct Transport<'a> {
    /// Method for light that fog scatters.
    pub volume: VolumeMethod,
    /// Maximum number of reflections by mirrors.
    pub mirror_depth: u32,
    /// Indirect light, which surfaces and fog scatter again; it includes that of the sky.
    pub indirect: Option<&'a Indirect>,
    /// Whether [`Sample::surface`](super::Sample::surface) is wanted.
    pub features: bool,
}

/// Memory that rays of one thread share.
#[derive(Default)]
pub struct Scratch {
    pub(super) lit: LitSegments,
    pub(super) lights: Vec<FrozenLight>,
}

/// Light that is followed: a picture may be the sum of one picture a light.
#[derive(Clone, Copy)]
pub(super) struct Illumination<'a> {
    pub(super) lights: &'a [FrozenLight],
    /// Whether the rest belongs to it: emission, the background and indirect light.
    pub(super) has_rest: bool,
    /// Whether the light of the sky belongs to it.
    pub(super) sky: bool,
    /// Whether it is seen in a surface that shines: shine seen in shine is as blurred as a grid tells it.
    pub(super) is_in_shine: bool,
    /// Whether what reaches the eye after one scattering is left out.
    pub(super) indirect_alone: bool,
    /// Walks that branch off the camera ray.
    pub(super) branches: Branches,
}

impl Illumination<'_> {
    /// Emission of a surface, as far as it is wanted.
    pub(super) fn emitted(&self, point: &SurfacePoint) -> Rgb {
        if self.has_rest { point.emission } else { Rgb::ZERO }
    }

    /// Radiance of the background in a direction, as far as it is wanted.
    pub(super) fn background(&self, snapshot: &Snapshot, direction: DVec3, from: Start) -> Rgb {
        match from {
            _ if !self.has_rest => Rgb::ZERO,
            Start::Camera => snapshot.seen_beyond(direction),
            Start::Surface(_) | Start::Shine(_) => snapshot.radiance_beyond(direction),
        }
    }
}

/// Start of a ray that is followed.
#[derive(Clone, Copy)]
pub(super) enum Start {
    /// The eye, whose clipping planes hide surfaces.
    Camera,
    /// A mirror.
    Surface(PrimitiveId),
    /// A surface that shines: what lies beyond the scene is looked for by itself.
    Shine(PrimitiveId),
}

impl Start {
    /// The triangle that a ray leaves.
    pub(super) fn leaving(self) -> Option<PrimitiveId> {
        match self {
            Self::Camera => None,
            Self::Surface(primitive) | Self::Shine(primitive) => Some(primitive),
        }
    }

    /// Whether rays from there see a triangle.
    pub(super) fn sees(self, snapshot: &Snapshot, primitive: PrimitiveId) -> bool {
        !matches!(self, Self::Camera) || snapshot.is_seen(primitive)
    }

    /// Whether they see a hole in the picture in its place.
    pub(super) fn sees_hole(self, snapshot: &Snapshot, primitive: PrimitiveId) -> bool {
        matches!(self, Self::Camera) && snapshot.is_holdout(primitive)
    }
}

/// A path that is being followed.
pub(super) struct Path<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) transport: &'a Transport<'a>,
    pub(super) light: Illumination<'a>,
    pub(super) sampler: &'a mut Sampler,
    pub(super) scratch: &'a mut Scratch,
}

impl<'a> Path<'a> {
    /// Fog on a ray from a start, if it is known for all rays from there.
    pub(super) fn seen_fog<'r>(&self, ray: &'r Ray, from: Start) -> Option<SeenRay<'r>>
    where
        'a: 'r,
    {
        let is_known = matches!(from, Start::Camera) && self.transport.volume == VolumeMethod::Segments;
        self.snapshot.seen_fog().filter(|_| is_known).map(|fog| fog.along(ray))
    }

    /// Optical depth of the fog between where a ray begins and the sky.
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

    /// Indirect light, if it is wanted here from a grid.
    pub(super) fn indirect(&self) -> Option<&'a Indirect> {
        self.transport.indirect.filter(|_| self.light.has_rest)
    }

    /// Maximum number of scatterings by random walks, if they are wanted.
    pub(super) fn walks(&self) -> Option<Bounces> {
        match self.transport.volume {
            VolumeMethod::Paths(bounces) if bounces != Bounces::NONE => Some(bounces),
            _ => None,
        }
    }

    /// Whether light of the sky is found by a ray in a random direction and counts as direct light: not if it
    /// counts as indirect light, as on a grid. A grid has no sky with a sun in it, so that there direct light
    /// is all that it would be without.
    pub(super) fn samples_sky(&self) -> bool {
        self.light.sky && !self.transport.indirect.is_some_and(Indirect::has_sky) && !self.walks_have_sky()
    }

    /// Whether random walks begin with it.
    pub(super) fn walks_have_sky(&self) -> bool {
        self.walks().is_some() && self.snapshot.sky.is_some_and(|sky| !sky.has_sun())
    }
}
