"""Fog and render settings as custom properties. Fog in a box also has a guide box."""

from pxr import Gf, Sdf, Vt

from ..gltf.nodes import Node
from ..gltf.scene import Gltf
from .prims import Names, Prim, Types
from .properties import write_properties
from .samples import Sampler

ENVIRONMENT = "sunfleck_env"
OF_SCENE = ("sunfleck", ENVIRONMENT, "sunfleck_fog")


def write_scene(prim: Prim, gltf: Gltf, sampler: Sampler, sky_picture: Sdf.AssetPath | None) -> None:
    """Writes the properties of the scene; the sky's image is a file."""
    for name in OF_SCENE:
        fields = gltf.extras.group(name).raw
        if isinstance(fields, dict):
            fields = {
                field: sky_picture if field == "image" and name == ENVIRONMENT else value
                for field, value in fields.items()
            }
            write_properties(prim, name, fields, "scene", gltf, sampler)


def write_fog(prim: Prim, node: Node, gltf: Gltf, sampler: Sampler, names: Names) -> None:
    """Writes the fog of a node: the image of the cube from -1 to 1."""
    fog = node.extras.group("sunfleck_fog_volume")
    write_properties(prim, "sunfleck_fog_volume", fog.raw, node.name, gltf, sampler)
    if fog.text_at("shape", "box") != "box":
        return
    cube = prim.child(names.new(f"{node.name}_bounds"), "Cube")
    cube.set("size", Types.Double, 2.0)
    cube.set("extent", Types.Float3Array, Vt.Vec3fArray([Gf.Vec3f(-1), Gf.Vec3f(1)]))
    # Visible as a guide, and not rendered.
    cube.set("purpose", Types.Token, "guide", uniform=True)


def write_metadata(layer: Sdf.Layer, gltf: Gltf, default: str, comment: str) -> None:
    """Writes the stage's units, axes and frames."""
    settings = gltf.settings
    layer.defaultPrim = default
    layer.documentation = comment
    layer.startTimeCode, layer.endTimeCode = float(settings.first), float(settings.last)
    # Time codes are frames.
    layer.timeCodesPerSecond = layer.framesPerSecond = float(settings.fps)
    layer.pseudoRoot.SetInfo("metersPerUnit", 1.0)
    layer.pseudoRoot.SetInfo("upAxis", "Y")
