//! Scene: resolved, in SI units, keyframed. In goes a [`crate::description`], out comes a [`Scene`].
//! Invariant: a `Scene` that exists is valid; every index is in range, every number is finite and in range,
//! parents come before children.

mod animation;
mod baking;
mod camera;
mod darkness;
mod default_light;
mod default_view;
mod deformation;
mod disc_picture;
mod drift;
mod fall;
mod flatness;
mod fog;
mod from_gltf;
mod from_ron;
mod grids;
mod hashed;
mod julia;
mod keyed;
mod lamp_traits;
mod light;
mod limits;
mod material;
mod matte;
mod mesh;
mod mist;
mod motion;
mod options;
mod outline;
mod ray_visibility;
mod resolve;
mod settings;
mod sky;
mod sun_picture;
mod texture;
mod track;

use crate::color::Rgb;
use crate::diagnostic::Diagnostics;
use crate::math::large_list;
use glam::{DAffine3, Vec3};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

pub use animation::Animation;
pub use baking::Baking;
pub use camera::{Aperture, Camera, Clip, Lens};
pub use darkness::{DarkCause, dark_cause};
pub use deformation::{Deformation, Influences, InnerVertex, Joint, MorphTarget, Pose, Shape, Skin};
pub use disc_picture::{DISC_CELLS, DiscPicture, limb_darkening};
pub use fog::{Fog, FogShape, HeightFalloff, MOST_FOGS};
pub use grids::{FogPart, FogVoxels, GridFrame, GridFrames, GridNames};
pub use hashed::Hashed;
pub use julia::Julia;
pub use keyed::Keyed;
pub use lamp_traits::LampTraits;
pub use light::{AreaShape, Light, LightKind, SunDisc};
pub use material::{
    AlphaMode, Clearcoat, Coat, Dielectric, Material, MaterialNumbers, Painted, Sheen, TextureMap,
};
pub use matte::{matte_id, murmur3};
pub use mesh::{Mesh, Triangle};
pub use mist::{GroundHeights, MOST_MIST_VOXELS, Mist, MistShape};
pub use motion::{Motion, Rotation};
pub use options::{LightUnits, ResolveOptions};
pub use outline::OUTLINE_TOLERANCE_TEXELS;
pub use ray_visibility::RayVisibility;
pub use resolve::{resolve, resolve_telling};
pub use settings::{Bounces, FrameRate, PixelFilter, RenderSettings, Sampling, Size, Window};
pub use sky::{Sky, SkyLight, SkyPicture, SkySun};
pub use sun_picture::{MOST_SUN_PICTURES, SunPicture, SunShows};
pub use texture::{Texture, Wrap};
use track::SmoothKey;
pub use track::{Animate, Extend, Handle, Key, Segment, Track};

/// Contents of a scene at all times. Immutable once built.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The transform hierarchy, parents before children.
    pub nodes: Vec<Node>,
    /// Triangle meshes, each shared by any number of instances.
    pub meshes: Vec<Mesh>,
    /// Materials of surfaces.
    pub materials: Vec<Material>,
    /// Images that materials refer to.
    pub textures: Vec<Texture>,
    /// Meshes placed at nodes.
    pub instances: Vec<Instance>,
    /// Ray visibility of nodes whose meshes some rays ignore.
    pub ray_visibility: BTreeMap<NodeIndex, RayVisibility>,
    /// Cameras; [`RenderSettings::camera`] picks one by name, else the first.
    pub cameras: Vec<Camera>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Traits of lamps, by their nodes.
    pub lamp_traits: BTreeMap<NodeIndex, LampTraits>,
    /// Units assumed for the lights of a glTF file, if neither it nor the options name any.
    pub guessed_light_units: Option<LightUnits>,
    /// Fog volumes.
    pub fogs: Vec<Fog>,
    /// Radiance of rays that leave the scene, W m^-2 sr^-1; it lights nothing.
    pub background: Rgb,
    /// Sky behind the scene, added to the background; it lights the scene.
    pub sky: Option<Sky>,
    /// Sky for the camera alone, in place of the sky; mirrors see the sky.
    pub backdrop: Option<Sky>,
    /// Animations of a glTF file, whether or not they play.
    pub animations: Vec<Animation>,
    /// Custom properties of a glTF file for this program, unparsed.
    pub properties: Vec<Property>,
    /// Requests of the description that are not honoured, or only approximated.
    pub remarks: Diagnostics,
}

/// Index into [`Scene::nodes`].
pub type NodeIndex = usize;
/// Index into [`Scene::meshes`].
pub type MeshIndex = usize;
/// Index into [`Scene::materials`].
pub type MaterialIndex = usize;
/// Index into [`Scene::textures`].
pub type TextureIndex = usize;

/// Named, possibly moving place below a parent.
#[derive(Clone, Debug)]
pub struct Node {
    /// The author's name, which need not be unique.
    pub name: String,
    /// Parent, always with a smaller index.
    pub parent: Option<NodeIndex>,
    /// Motion in its parent's space.
    pub motion: Motion,
    /// Whether the node and all its descendants are visible.
    pub visible: Track<bool>,
}

/// Custom property of a glTF file for this program.
#[derive(Clone, Debug)]
pub struct Property {
    /// Owner, for messages.
    pub owner: String,
    /// Name, `sunfleck...`.
    pub name: String,
    /// JSON value.
    pub value: serde_json::Value,
}

/// Mesh at a node.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Node.
    pub node: NodeIndex,
    /// Mesh.
    pub mesh: MeshIndex,
    /// Material that replaces all of the mesh's own.
    pub material: Option<MaterialIndex>,
    /// Id in the `leaf_id` pass; 0 is the background, so ids start at 1.
    pub leaf_id: u32,
    /// Deformation of the mesh, if it has one.
    pub deformation: Option<Arc<Deformation>>,
}

/// Placement of a node at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Transform from the node's own space to the world's.
    pub world_from_node: DAffine3,
    /// False if the node or any of its ancestors is hidden.
    pub visible: bool,
}

impl Placement {
    /// Placement of the world itself.
    const ROOT: Self = Self { world_from_node: DAffine3::IDENTITY, visible: true };

    /// Placement of a node below this one.
    fn below(self, node: &Node, time_s: f64) -> Self {
        Self {
            world_from_node: self.world_from_node * node.motion.parent_from_node(time_s),
            visible: self.visible && node.visible.at(time_s),
        }
    }
}

impl Scene {
    /// Adds a visible node; returns its index.
    pub(crate) fn add_node(&mut self, name: String, parent: Option<NodeIndex>, motion: Motion) -> NodeIndex {
        // Formatted names have room to spare, and a wood has hundreds of thousands of leaves.
        let name = name.as_str().to_owned();
        self.nodes.push(Node { name, parent, motion, visible: Track::from(true) });
        self.nodes.len() - 1
    }

    /// Placements of all nodes at `time_s`, in the order of [`Scene::nodes`].
    pub fn placements(&self, time_s: f64) -> Vec<Placement> {
        let mut placements: Vec<Placement> = large_list(self.nodes.len());
        for node in &self.nodes {
            let parent = node.parent.map_or(Placement::ROOT, |parent| placements[parent]);
            placements.push(parent.below(node, time_s));
        }
        placements
    }

    /// Placement of a single node, with the same bits.
    pub fn placement(&self, node: NodeIndex, time_s: f64) -> Placement {
        let ancestors: Vec<&Node> = self.with_ancestors(node).collect();
        ancestors.iter().rev().fold(Placement::ROOT, |parent, node| parent.below(node, time_s))
    }

    /// Whether a node and all its ancestors are visible at a time: [`Placement::visible`] of a single node.
    pub fn is_visible(&self, node: NodeIndex, time_s: f64) -> bool {
        self.with_ancestors(node).all(|node| node.visible.at(time_s))
    }

    /// Whether no key moves a node.
    pub fn stays(&self, node: NodeIndex) -> bool {
        self.with_ancestors(node).all(|node| node.motion.is_still())
    }

    /// A node, its parent, and so on.
    fn with_ancestors(&self, node: NodeIndex) -> impl Iterator<Item = &Node> {
        let of = |node: NodeIndex| &self.nodes[node];
        std::iter::successors(Some(of(node)), move |node| node.parent.map(of))
    }

    /// Drops keys of baked falls that no time in a span needs. Nothing else changes.
    pub fn keep_span(&mut self, span_s: (f64, f64)) {
        let before = self.nodes.iter_mut().filter_map(|node| node.motion.keep_span(span_s));
        // Freed together: a block freed alone would have the next curve's small blocks, and leave a hole.
        drop(before.collect::<Vec<_>>());
    }

    /// Vertices of an instance at the time of `placements`, and the transform of their space.
    pub fn vertices(
        &self,
        instance: &Instance,
        placements: &[Placement],
        time_s: f64,
    ) -> (Cow<'_, [Vec3]>, DAffine3) {
        let mesh = &self.meshes[instance.mesh];
        match &instance.deformation {
            None => (Cow::Borrowed(&mesh.positions), placements[instance.node].world_from_node),
            Some(deformation) => {
                let (pose, world_from_shape) = deformation.pose(placements, instance.node, time_s);
                (Cow::Owned(deformation.shape(mesh, &pose).positions), world_from_shape)
            }
        }
    }

    /// Name of an instance's matte: its node's.
    pub fn matte_name(&self, instance: usize) -> &str {
        &self.nodes[self.instances[instance].node].name
    }
}
