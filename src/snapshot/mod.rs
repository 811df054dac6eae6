//! One shutter interval, prepared for tracing. In go a [`Scene`], its mesh trees and a time, out comes a
//! [`Snapshot`]. Invariants: `Snapshot::new` is pure. After it there is no frame number and no absolute time.
//! Everything is in *relative space*: world axes, with the camera at the origin. The camera is subtracted in
//! double precision, so a scene far from the world's origin loses no precision.

mod bent_mesh;
mod blended;
mod contents;
mod emissive_surfaces;
mod exposure;
mod fog_lattice;
mod lens;
mod luminaire;
mod mesh_parts;
mod mesh_trees;
mod middle;
mod moment;
mod motion_field;
mod placed_mesh;
mod ray_visibility;
mod seen_fog;
mod self_shading;
mod shown_lamps;
mod sky;
mod still;
mod surface;

use crate::accel::{InstanceTree, PrimitiveId};
use crate::color::Rgb;
use crate::fog::Medium;
use crate::scene::{Material, RenderSettings, Scene};
use glam::{DAffine3, DVec3};
use middle::Middle;
use moment::{Moment, Placed, lights_on};
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};
use still::Still;

pub use crate::light::{Cone, Emission, FrozenLight, LampShape, LightPlace};
pub use blended::{BlendedHit, NEGLIGIBLE};
pub use contents::Contents;
pub use emissive_surfaces::EmissiveSurfaces;
pub use exposure::Exposure;
pub use lens::View;
pub use luminaire::{Luminaire, Watcher};
pub use mesh_parts::{MeshPart, PartPlace};
pub use mesh_trees::MeshTrees;
pub use motion_field::MotionField;
pub use placed_mesh::DrawnMesh;
pub use ray_visibility::RaysOfInstances;
pub use seen_fog::{SeenFog, SeenRay};
pub use sky::FrozenSky;
pub use surface::{Facet, SurfacePoint};

/// Interval for which the shutter is open, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// Time of opening.
    pub open_s: f64,
    /// Time of closing; not before it opens.
    pub close_s: f64,
}

impl Shutter {
    /// Shutter of a frame.
    pub fn of(settings: &RenderSettings, frame: f64) -> Self {
        let [open_s, close_s] =
            settings.shutter_around(frame).map(|frame| settings.frame_rate.seconds(frame));
        Self { open_s, close_s }
    }

    /// Shutter that is open at a moment only, in seconds.
    pub fn instant(moment_s: f64) -> Self {
        Self { open_s: moment_s, close_s: moment_s }
    }

    /// The moment of a picture without motion blur.
    pub fn middle_s(self) -> f64 {
        0.5 * (self.open_s + self.close_s)
    }
}

/// The scene of one moment, for all queries of rays.
pub struct Snapshot<'scene> {
    scene: &'scene Scene,
    /// The camera.
    pub view: View,
    /// All visible opaque triangles.
    pub tree: InstanceTree,
    /// All visible triangles that transmit light straight through.
    pub blended: InstanceTree,
    /// Shadow casters of both trees; `None` if these are all instances.
    casting: Option<[InstanceTree; 2]>,
    /// Ray visibility of the instances of both trees, by number; `None` if all rays meet all of them.
    rays: Option<RaysOfInstances>,
    /// The scene's materials at this moment.
    materials: Cow<'scene, [Material]>,
    /// Whether a material transmits light straight through, by material.
    is_blended: Arc<[bool]>,
    /// Connected parts of the scene's meshes.
    parts: Arc<mesh_parts::MeshParts>,
    /// Instances of both trees, by number.
    placed: Vec<Placed>,
    /// Number of the first instance of `blended`.
    first_blended: usize,
    /// All lights that emit.
    pub lights: Vec<Luminaire>,
    /// All fog.
    pub medium: Medium,
    /// Radiance of rays that leave the scene, without the sky and without suns.
    pub background: Rgb,
    /// The sky, unless it is dark.
    pub sky: Option<FrozenSky<'scene>>,
    /// Sky that the camera sees instead.
    pub backdrop: Option<FrozenSky<'scene>>,
    /// Places of moving surfaces in the middle of the shutter, for its other moments.
    middle: Arc<Middle>,
    /// Motion of surfaces, if it is requested.
    pub motion: Option<Arc<MotionField>>,
    /// Cryptomatte ids of the scene's instances, if they are requested.
    pub mattes: Option<Arc<[u32]>>,
    /// Fog along camera rays, if it was precomputed.
    seen_fog: OnceLock<Arc<SeenFog>>,
    /// Emissive surfaces, after their first use.
    emissive: OnceLock<Option<EmissiveSurfaces>>,
}

/// A moment of a frame.
#[derive(Clone, Copy)]
struct Instant<'a> {
    time_s: f64,
    /// Middle of the shutter.
    frame_s: f64,
    /// Instances that are still at all of the shutter's moments.
    still: Option<&'a Still>,
}

/// Camera of a snapshot, and width / height of its picture.
#[derive(Clone, Copy)]
struct Framing {
    camera: usize,
    aspect: f64,
}

impl<'scene> Snapshot<'scene> {
    /// Freezes `scene` as seen by its camera number `camera` in the middle of `shutter`.
    ///
    /// `aspect` is width / height of the whole picture.
    pub fn new(
        scene: &'scene Scene,
        trees: &MeshTrees,
        camera: usize,
        aspect: f64,
        shutter: Shutter,
    ) -> Self {
        let time_s = shutter.middle_s();
        let instant = Instant { time_s, frame_s: time_s, still: None };
        Self::at(scene, trees, Framing { camera, aspect }, instant, &lights_on(scene, time_s))
    }

    /// Freezes a moment, with those of the scene's lights that `lights_on` selects.
    fn at(
        scene: &'scene Scene,
        trees: &MeshTrees,
        Framing { camera, aspect }: Framing,
        Instant { time_s, frame_s, still }: Instant,
        lights_on: &[bool],
    ) -> Self {
        let placements = scene.placements(time_s);
        let camera = &scene.cameras[camera];
        let view = View::new(camera, placements[camera.node].world_from_node, aspect, time_s);
        let moment = Moment { scene, time_s, frame_s, placements, eye: view.eye, still };
        let contents = Contents::of(&moment, trees, lights_on);
        drop(moment);
        contents.seen_by(view)
    }

    /// Transform of an instance.
    fn relative_from_mesh(&self, number: usize) -> DAffine3 {
        let tree = if number < self.first_blended { &self.tree } else { &self.blended };
        tree.relative_from_mesh(number as u32)
    }

    /// Whether any surface is glossy.
    pub fn has_gloss(&self) -> bool {
        self.materials.iter().any(|material| material.coat.is_some())
    }

    /// Whether any visible surface transmits light straight through.
    pub fn has_blended(&self) -> bool {
        !self.blended.is_empty()
    }

    /// Radiance of a ray that leaves the scene in that direction.
    pub fn radiance_beyond(&self, direction: DVec3) -> Rgb {
        let sky = self.sky.as_ref().map_or(Rgb::ZERO, |sky| sky.along(direction));
        self.background + sky + self.suns_along(direction)
    }

    /// Radiance beyond the scene on a camera ray; the sky may be hidden from the camera.
    pub fn seen_beyond(&self, direction: DVec3) -> Rgb {
        let suns = || self.suns_along(direction);
        match (&self.backdrop, &self.sky) {
            (Some(backdrop), _) => backdrop.along(direction) + suns(),
            (None, Some(sky)) if !sky.is_seen() => self.background + suns(),
            _ => self.radiance_beyond(direction),
        }
    }

    /// The part of it that is the discs of suns.
    pub fn suns_along(&self, direction: DVec3) -> Rgb {
        self.lights.iter().map(|light| light.seen_along(direction)).sum()
    }

    /// Whether camera rays that leave the scene see a background, suns aside.
    pub fn has_background(&self) -> bool {
        let is_seen = self.backdrop.is_some() || self.sky.is_some_and(|sky| sky.is_seen());
        is_seen || self.background != Rgb::ZERO
    }

    /// Whether no camera ray that leaves the scene sees any light, not even a sun or lamp.
    pub fn is_dark_beyond(&self) -> bool {
        !self.has_background() && !self.lights.iter().any(Luminaire::is_visible)
    }

    /// Fog along camera rays, once [`Exposure::see_fog`] has computed it.
    pub fn seen_fog(&self) -> Option<&SeenFog> {
        self.seen_fog.get().map(|seen| &**seen)
    }

    /// Motion of the surface point that a ray hit, or of objects at infinity in its direction; see
    /// [`MotionField`]. 0 unless motion is requested.
    pub fn motion_px(&self, surface: Option<&SurfacePoint>, direction: DVec3) -> [f64; 4] {
        let Some(motion) = &self.motion else { return [0.0; 4] };
        let Some(point) = surface else { return motion.of_direction(direction) };
        let weights = self.facet(point.primitive).weights_at(point.position);
        let instance = self.placed[point.primitive.instance as usize].instance();
        motion.of_point(self.scene, instance, point.primitive.triangle as usize, weights)
    }

    /// Cryptomatte id of the object that a triangle belongs to; 0 unless ids are requested.
    pub fn matte_id(&self, primitive: PrimitiveId) -> u32 {
        let instance = self.placed[primitive.instance as usize].instance();
        self.mattes.as_ref().map_or(0, |mattes| mattes[instance])
    }

    /// A point of relative space in world space.
    pub fn world_from_relative(&self, point: DVec3) -> DVec3 {
        point + self.view.eye
    }
}
