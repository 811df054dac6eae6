//! Losses: kinds of requests that an input makes and that are not honoured, with ids that stay. `inspect
//! --json` and `--stats` list them, `--strict` refuses them. Invariant: a kind's id is never given to
//! another; docs/losses.md lists all of them.

use std::fmt;

/// Defines [`Loss`] from rows of variant, id and sentence.
macro_rules! losses {
    ($($variant:ident $id:literal $sentence:literal)*) => {
        /// A kind of loss. To add one, add a row to the table below and to docs/losses.md.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Loss { $(#[doc = $sentence] $variant,)* }

        impl Loss {
            /// All of them, in the table's order.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// The id, lower case with hyphens.
            pub fn id(self) -> &'static str {
                match self { $(Self::$variant => $id,)* }
            }

            /// Sentence without a full stop: the loss, and what is done instead.
            pub fn sentence(self) -> &'static str {
                match self { $(Self::$variant => $sentence,)* }
            }
        }
    };
}

losses! {
    PointsAndLines "points-and-lines" "points and lines are not drawn"
    MaterialVariants "material-variants" "material variants are not honoured, the default one is drawn"
    NormalsWithoutLength "normals-without-length" "some normals have no length, these meshes are shaded flat"
    TextureCoordinatesMissing "texture-coordinates-missing" "these meshes have textures but no texture coordinates, the corner texel is used"
    VertexColorSets "vertex-color-sets" "vertex colours after the first are not honoured (COLOR_1)"
    TangentsUnusable "tangents-unusable" "some tangents have no length or no side, these meshes get those of their texture coordinates"
    NormalMapUnusable "normal-map-unusable" "where thousands of triangles meet in one place, normal maps are not honoured"
    VertexAlpha "vertex-alpha" "alpha of vertex colours is not honoured beside a texture that masks"
    JointWeights "joint-weights" "weights of joints that do not add up to 1 are scaled so that they do"
    SkinWithoutJoints "skin-without-joints" "skins of meshes that do not say what they hang on are passed over"
    MorphTargetAttributes "morph-target-attributes" "morph targets change positions, normals and tangents alone, not these"
    MorphWeightsWithoutTargets "morph-weights-without-targets" "weights of meshes without morph targets are passed over"
    InstancesWithoutMesh "instances-without-mesh" "instances of nodes without a mesh are passed over"
    InstancesOfSkins "instances-of-skins" "instances do not follow skeletons, these keep the shape at rest"
    InstanceAttributes "instance-attributes" "instances differ in place, rotation, scale and colour alone, not in these"
    MeshWithoutTriangles "mesh-without-triangles" "meshes without triangles are left out"
    NodesOutsideScene "nodes-outside-scene" "nodes outside the scene are passed over"
    OtherScenes "other-scenes" "only one scene is read, the others are passed over"
    ReferenceMissing "reference-missing" "what refers to something that the file does not hold is passed over"
    PrimitiveDamaged "primitive-damaged" "parts of meshes that cannot be read are left out"
    PrimitiveWithoutPositions "primitive-without-positions" "primitives without positions are left out"
    AttributeDamaged "attribute-damaged" "normals, texture coordinates, colours and tangents that cannot be read are left out"
    TrianglesIncomplete "triangles-incomplete" "vertices after the last whole triangle are left out"
    MorphTargetsDamaged "morph-targets-damaged" "morph targets and weights that cannot be read are passed over"
    SkinDamaged "skin-damaged" "skins that cannot be read are passed over, their meshes keep the shape at rest"
    InstancesDamaged "instances-damaged" "instances that cannot be read are passed over, the mesh is drawn once"
    AnimationDamaged "animation-damaged" "channels of animations that cannot be read are passed over"
    AnimationsLeftOut "animations-left-out" "animations that move what an earlier one moves are not played"
    TextureUnreadable "texture-unreadable" "textures that cannot be read are left out, the plain factors are used"
    BufferUnreadable "buffer-unreadable" "buffers are missing or cut short, what would lie there is left out"
    ValueOutOfRange "value-out-of-range" "values out of their range are put back into it"
    HierarchyRepaired "hierarchy-repaired" "nodes in several places of the hierarchy stand in the first of them"
    TransformRepaired "transform-repaired" "rotations are scaled to length 1, or passed over without length; of matrices the affine part counts"
    CameraUnusable "camera-unusable" "cameras without a usable lens are left out"
    LightUnusable "light-unusable" "lights of no known kind, and spots whose cone has no width, are left out"
    ContainerRest "container-rest" "chunks and bytes that glTF does not know are passed over"
    NothingToDraw "nothing-to-draw" "the scene holds no surface, no fog and no sky"
    UnknownExtension "unknown-extension" "extensions that are not known are passed over"
    ExtensionPassedOver "extension-passed-over" "what these extensions add is passed over, the file's plain data are used"
    ExtensionWithoutPicture "extension-without-picture" "required extensions that add nothing to a picture are passed over"
    AnimationsConflict "animations-conflict" "several animations move the same property of a node, the last one is played"
    AnimatedValuesConflict "animated-values-conflict" "several animations change the same value, the last one is played"
    AnimationPointer "animation-pointer" "values that are animated by a pointer and not honoured keep still"
    AnimationWithoutTarget "animation-without-target" "channels that target no node are passed over"
    SpotAnglePointer "spot-angle-pointer" "Blender's exporter puts a dot for a slash before the angles of spots, they are read as meant"
    KeysOutsideFrames "keys-outside-frames" "no key lies on the frames that are to be rendered"
    CarriedValueWithoutTarget "carried-value-without-target" "values carried by `sunfleck_ctl` find no such target, they are passed over"
    AnimatedMask "animated-mask" "masks are cut out once: where alpha is animated they are those of the still value"
    SheenMadeWeaker "sheen-made-weaker" "sheens smoother than 0.3 give back more than they receive at grazing angles, there they are made weaker"
    OcclusionMap "occlusion-map" "occlusion maps are not honoured: what stands around dims light from all around"
    SpecularTextures "specular-textures" "textures of specular reflection and transmission are not honoured, the plain factors are used"
    TextureFilter "texture-filter" "textures are smooth between texels, also those that ask for squares"
    TransmissionRough "transmission-rough" "what transparent materials let through goes straight on, neither bent nor blurred"
    TransmissionVolume "transmission-volume" "the inside of transparent materials is not honoured, light goes straight through"
    Anisotropy "anisotropy" "anisotropy of highlights is not honoured"
    Iridescence "iridescence" "iridescence is not honoured"
    UnknownMaterialExtension "unknown-material-extension" "extensions of materials that are not known are passed over"
    BackfaceCulling "backface-culling" "backface culling is not honoured, these materials show from both sides"
    MaskTooFine "mask-too-fine" "masks of hardly anything but edges are not cut out, these meshes are drawn whole"
    MaskTooWide "mask-too-wide" "texture coordinates reach too far for masks to be cut out, these meshes are drawn whole"
    LightWithoutShafts "light-without-shafts" "lights that cast no shafts are not honoured, they cast them"
    LightOfNoFile "light-of-no-file" "`sunfleck_light` describes a light that the file does not hold, it is left out"
    AreaLightSpread "area-light-spread" "an area light's spread below 0.01 radians is not honoured, it is as wide as that"
    LightRange "light-range" "a light's range is not honoured, it shines without limit"
    SpotAngles "spot-angles" "a spot's angles are not 0 <= inner <= outer <= pi/2, the nearest that are take their place"
    LightSize "light-size" "`angle` is a size of suns and `radius` one of points and spots, others are passed over"
    LightExposure "light-exposure" "Blender's exposure of these lights cannot be told from their animated intensities, it is taken as 0"
    LightIntensityUnits "light-intensity-units" "Blender's exporter writes animated intensities of lights in other units than still ones: these are put right"
    PictureOnLamp "picture-on-lamp" "pictures and limb darkening are of suns, of other lights they are passed over"
    SunWithoutAngle "sun-without-angle" "suns without an angle have no disc, they can neither be seen nor show a picture"
    ColorSpaceConflict "color-space-conflict" "a file's `colorInteropID` and chromaticities disagree, the id counts"
    ColorSpaceData "color-space-data" "images that say that they hold data, and no colours, are taken as linear light"
    ColorSpaceUnknown "color-space-unknown" "colour spaces whose names are not known are taken as chromaticities say, else as linear Rec. 709"
    RadianceExposure "radiance-exposure" "`EXPOSURE` of Radiance images is passed over, as Blender passes over it"
    NoPicture "no-picture" "of a frame without R, G and B other channels are shown, what lacks is black"
    NegativeRadiance "negative-radiance" "radiances below 0 in images of skies count as 0"
    NoLight "no-light" "nothing lights the scene"
    ClippingPlanes "clipping-planes" "clipping planes that leave nothing between them are ignored"
    DarkFrame "dark-frame" "frames are next to black, they are written as they are"
    IndirectLight "indirect-light" "indirect light may err by more than three times the tolerance, frames are written as they are"
    ApertureOrthographic "aperture-orthographic" "an aperture of orthographic cameras is not honoured, all is in focus"
    ShutterInstant "shutter-instant" "a shutter that opens for an instant does so at the frame"
    MotionBlurMoments "motion-blur-moments" "motion blur is drawn from fewer moments of the shutter"
    SharedGridName "shared-grid-name" "of several grids of one name in a file the first counts"
    FogHeld "fog-held" "fog of numbered files without velocities, or with such as carry it over 64 voxels, jumps from one to the next while the shutter is open"
    FogBounds "fog-bounds" "`bounds` of a `sunfleck_fog_volume` is passed over, the node is the box"
    UnknownField "unknown-field" "unknown fields of sunfleck's properties are passed over"
    UnknownProperty "unknown-property" "properties that their owners do not have are passed over"
    UnitScale "unit-scale" "Blender's unit scale changes how it shows lengths, not the scene: one unit is one metre, as to Cycles"
    ObjStatement "obj-statement" "statements of OBJ files that are not known are passed over"
    ObjNumbers "obj-numbers" "lines whose numbers cannot be read, or are too few, are left out"
    ObjThinFace "obj-thin-face" "faces of fewer than three corners are left out"
    ObjFaceIndex "obj-face-index" "faces that refer to vertices which the file does not have are left out"
    ObjFaceVertex "obj-face-vertex" "faces with a vertex whose numbers cannot be read are left out"
    ObjFaceCorners "obj-face-corners" "faces of more than 2048 corners are left out"
    ObjCrossingFace "obj-crossing-face" "faces have outlines that cross themselves, their triangles may overlap"
    ObjMaterialMissing "obj-material-missing" "no MTL file has the material, the default one takes its place"
    ObjNormals "obj-normals" "some corners of these faces have no normal, the faces are drawn as those without"
    ObjTextureCoordinates "obj-texture-coordinates" "some corners of these faces have no texture coordinates, the faces have none"
    ObjVertexColors "obj-vertex-colors" "colours of vertices are from 0 to 1, others are put into that range"
    MtlMissing "mtl-missing" "MTL files that are not there leave the default material in their materials' place"
    MtlUnnamed "mtl-unnamed" "materials without a name are of faces whose `usemtl` has none"
    MtlStatement "mtl-statement" "statements of MTL files that are not honoured are passed over"
    MtlValue "mtl-value" "values of MTL files that cannot be are put into their range, or left out"
    MtlTexture "mtl-texture" "textures of MTL files are missing or cannot be read, grey takes the place of colours"
    MtlTextureOption "mtl-texture-option" "options of textures that are not honoured are passed over"
    MtlBumpMap "mtl-bump-map" "maps of heights do not bend normals, normal maps do"
    LeavesInTheAir "leaves-in-the-air" "leaves stay in the air, as they fall for longer than is computed"
    ExportNegativeTimes "export-negative-times" "glTF has no times before 0, motion before frame 0 is not carried"
    ExportSky "export-sky" "the sky does not change in glTF, it stays as it is at the start"
    ExportChange "export-change" "a change of a material is not carried by glTF"
    ExportMaterial "export-material" "what a material shows is not carried by glTF"
    ExportMist "export-mist" "billows of mist are not carried by glTF, their bank of fog is left out"
    ExportShape "export-shape" "what bends is carried to a tolerance"
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}
