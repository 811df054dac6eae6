"""Properties for sunfleck that Blender lacks. All other settings are Blender's own."""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

PASSES = [
    ("shafts", "Shafts", "Light scattered in the fog"),
    ("transmittance", "Transmittance", "What the fog lets through"),
    ("indirect", "Indirect", "Of the picture, what surfaces show of indirect light"),
    ("indirect-shafts", "Indirect shafts", "Of the shafts, what fog scatters of it"),
    ("depth", "Depth", "Distance along the view"),
    ("normal", "Normal", "Shading normal"),
    ("position", "Position", "Place in the world"),
    ("albedo", "Albedo", "Reflectance"),
    ("leaf-id", "Leaf id", "Which object"),
    ("error", "Error", "Estimated relative error"),
    ("motion", "Vector", "Where things move, in pixels"),
    ("cryptomatte", "Cryptomatte", "Which objects cover how much of a pixel"),
]


FILTERS = [
    ("box", "Box", "The pixel itself, everywhere alike"),
    ("blackman-harris", "Blackman-Harris", "A window 1.5 pixels wide: what Cycles has unless told otherwise"),
]
SKY_LIGHTS = [
    ("nothing", "Nothing", "It is a background"),
    ("surfaces", "Surfaces", "It lights surfaces"),
    ("surfaces_and_fog", "Surfaces and fog", "It lights surfaces and fog"),
]


MIST_SHAPES = [
    ("box", "Box", "Fades at its sides and its top"),
    ("ellipsoid", "Ellipsoid", "Fades all around"),
]


SUN_SHOWS = [
    ("EVEN", "Nothing", "It is as bright everywhere"),
    ("IMAGE", "Image", "The middle of an image"),
    ("FRACTAL", "Fractal", "A Julia set"),
]


def colour(name, description, default=(1.0, 1.0, 1.0)):
    return FloatVectorProperty(
        name=name, description=description, subtype="COLOR", default=default, min=0.0, max=1.0
    )


def forgetting(*fields):
    """Update callback of a panel's property: it removes values for the same fields from earlier exports or
    by hand."""

    def forget(own, _context):
        said = own.id_data.get("sunfleck_light", {})
        for field in fields:
            if field in said:
                del said[field]

    return forget


class SunfleckFog:
    """Fields of fog, of the scene's and of a bounded one's."""

    density: FloatProperty(name="Density", description="Extinction, 1/m", default=0.05, min=0.0, soft_max=2.0)
    albedo: colour("Albedo", "Share of the extinction that is scattering")
    anisotropy: FloatProperty(
        name="Anisotropy", description="More than 0 scatters forward", default=0.5, min=-0.999, max=0.999
    )
    stored: StringProperty(description="Custom properties that the last export wrote", options={"HIDDEN"})


class SunfleckScene(SunfleckFog, bpy.types.PropertyGroup):
    tolerance: FloatProperty(
        name="Tolerance", description="Relative error of every block of pixels at which to stop",
        default=0.02, min=0.001, max=1.0,
    )
    use_samples: BoolProperty(name="Fixed samples", description="A number of samples instead of a tolerance")
    samples: IntProperty(name="Samples", default=16, min=1, max=65536)
    filter: EnumProperty(
        name="Filter", description="By what weights a pixel is the mean of the picture around it", items=FILTERS,
        default="box",
    )
    bounces: IntProperty(
        name="Bounces",
        default=0,
        min=0,
        max=64,
        description="How often light is scattered beyond direct light and single scattering",
    )
    all_bounces: BoolProperty(
        name="All light", description="Light is scattered until nothing is left of it", default=True
    )
    seed: IntProperty(name="Seed", default=0, min=0)
    passes: EnumProperty(
        name="Passes", items=PASSES, options={"ENUM_FLAG"}, default={"shafts", "depth", "leaf-id"}
    )
    use_fog: BoolProperty(name="Fog everywhere", description="Fog without bounds that thins out with height")
    scale_height: FloatProperty(
        name="Scale height", description="Metres over which the density falls to 1/e", default=3.0, min=0.01
    )
    base_height: FloatProperty(
        name="Base", description="Height above which it thins out, metres", default=0.0
    )
    background_color: colour("Background", "What lies beyond the scene")
    background_strength: FloatProperty(name="Strength", description="W/(m2 sr)", default=0.0, min=0.0)
    use_world: BoolProperty(
        name="World as sky", description="The world's colour or environment texture instead of the background"
    )
    sky_lights: EnumProperty(
        name="Lights", description="What the sky lights", items=SKY_LIGHTS, default="nothing"
    )


class SunfleckObject(SunfleckFog, bpy.types.PropertyGroup):
    is_fog: BoolProperty(
        name="Holds fog", description="This cube from -1 to 1 (an empty or a mesh) is full of fog"
    )
    thins_out: BoolProperty(name="Thins out with height")
    scale_height: FloatProperty(
        name="Scale height", description="Metres over which the density falls to 1/e", default=3.0, min=0.01
    )
    use_mist: BoolProperty(name="Mist that drifts", description="Billows instead of even fog")
    mist_size: FloatProperty(name="Billows", description="Width of the largest, metres", default=3.0, min=0.01)
    mist_octaves: IntProperty(name="Octaves", description="Sizes, each half of the one before", default=4, min=1, max=8)
    mist_cover: FloatProperty(name="Cover", description="The share that they fill", default=0.5, min=0.0, max=1.0)
    mist_wind: FloatVectorProperty(
        name="Wind", description="What carries them along this object's axes", subtype="VELOCITY",
        soft_min=-100.0, soft_max=100.0, min=-500.0, max=500.0,
    )
    mist_evolution_turns: FloatProperty(name="Evolution", description="How often they have turned over")
    mist_shape: EnumProperty(name="Shape", items=MIST_SHAPES, default="box")
    mist_seed: IntProperty(name="Seed", description="Another seed, other billows", default=0, min=0)
    use_leaf_id: BoolProperty(name="Leaf id", description="Its number in the pass; else counted")
    leaf_id: IntProperty(name="Leaf id", default=1, min=1, max=2**31 - 1)
    visible_to_camera: BoolProperty(
        name="Sun can be seen", description="The camera sees the disc of this sun",
        update=forgetting("visible_to_camera"),
    )
    sun_shows: EnumProperty(
        name="Disc shows", description="What is on the disc of this sun", items=SUN_SHOWS, default="EVEN",
        update=forgetting("image", "fractal", "picture_rotation"),
    )
    sun_image: PointerProperty(
        name="Image", description="The largest circle in its middle is on the disc", type=bpy.types.Image,
        update=forgetting("image"),
    )
    fractal_real: FloatProperty(
        name="Real part", description="Of the constant", default=-0.012375, min=-2.0, max=2.0
    )
    fractal_imaginary: FloatProperty(
        name="Imaginary part", description="Of the constant", default=0.56805, min=-2.0, max=2.0
    )
    fractal_iterations: IntProperty(
        name="Iterations",
        description="After so many a point counts as one that never escapes",
        default=100,
        min=1,
        max=1000,
    )
    picture_rotation: FloatProperty(name="Turned", description="Anticlockwise", subtype="ANGLE", default=0.0)
    limb_darkening: FloatProperty(
        name="Limb darkening", description="How much darker the disc's edge is; the real sun has about 0.6",
        default=0.0, min=0.0, max=1.0, update=forgetting("limb_darkening"),
    )


class SunfleckMaterial(bpy.types.PropertyGroup):
    stored: StringProperty(description="Custom properties that the last export wrote", options={"HIDDEN"})
    is_leaf: BoolProperty(name="Leaf", description="Light shines through")
    translucency: FloatProperty(
        name="Translucency", description="Share of the light that goes through", default=0.5, min=0.0, max=1.0
    )
    use_transmit_color: BoolProperty(name="Own colour", description="Else the base colour")
    transmit_color: colour("Transmitted", "Colour of the light that comes through", (0.6, 0.7, 0.1))


OWNERS = {bpy.types.Scene: SunfleckScene, bpy.types.Object: SunfleckObject, bpy.types.Material: SunfleckMaterial}


def register():
    for owner, group in OWNERS.items():
        bpy.utils.register_class(group)
        owner.sunfleck_settings = PointerProperty(type=group)


def unregister():
    for owner, group in OWNERS.items():
        del owner.sunfleck_settings
        bpy.utils.unregister_class(group)
