"""Known surface shaders, with the names of their inputs in UsdPreviewSurface.

UsdPreviewSurface is read fully. From others, colour, roughness, metal, emission, opacity and coat are
read, an approximation that is reported. Sources: the specifications of UsdPreviewSurface 2.6, Autodesk's
Standard Surface 1.0, OpenPBR 1.1, and MaterialX 1.39 for names of nodes.
"""

from dataclasses import dataclass, field

from pxr import UsdShade

DEFAULTS = {
    "diffuseColor": (0.18,) * 3, "emissiveColor": (0.0,) * 3, "useSpecularWorkflow": (0.0,), "specularColor": (0.0,) * 3,
    "metallic": (0.0,), "roughness": (0.5,), "clearcoat": (0.0,), "clearcoatRoughness": (0.01,), "opacity": (1.0,),
    "opacityThreshold": (0.0,), "ior": (1.5,), "normal": (0.0, 0.0, 1.0), "displacement": (0.0,), "occlusion": (1.0,),
}  # fmt: skip
"""Defaults of UsdPreviewSurface."""


@dataclass(frozen=True)
class Dialect:
    """A shader's names of UsdPreviewSurface's inputs; `weights` are inputs that multiply another."""

    names: dict[str, str]
    defaults: dict[str, tuple[float, ...]] = field(default_factory=dict)
    weights: dict[str, dict[str, float]] = field(default_factory=dict)
    is_exact: bool = False

    def default(self, name: str) -> tuple[float, ...]:
        """Default of an input, by its name in UsdPreviewSurface."""
        return self.defaults.get(name, DEFAULTS[name])


PREVIEW = Dialect({name: name for name in DEFAULTS}, is_exact=True)
STANDARD = Dialect(
    {"diffuseColor": "base_color", "metallic": "metalness", "roughness": "specular_roughness", "ior": "specular_IOR",
     "emissiveColor": "emission_color", "opacity": "opacity", "clearcoat": "coat", "clearcoatRoughness": "coat_roughness"},
    {"diffuseColor": (0.8,) * 3, "roughness": (0.2,), "emissiveColor": (1.0,) * 3, "clearcoatRoughness": (0.1,)},
    {"diffuseColor": {"base": 1.0}, "emissiveColor": {"emission": 0.0}},
)  # fmt: skip
OPEN_PBR = Dialect(
    {"diffuseColor": "base_color", "metallic": "base_metalness", "roughness": "specular_roughness", "ior": "specular_ior",
     "emissiveColor": "emission_color", "opacity": "geometry_opacity", "clearcoat": "coat_weight",
     "clearcoatRoughness": "coat_roughness"},
    {"diffuseColor": (0.8,) * 3, "roughness": (0.3,), "emissiveColor": (1.0,) * 3, "clearcoatRoughness": (0.0,)},
    {"diffuseColor": {"base_weight": 1.0}, "emissiveColor": {"emission_luminance": 0.0}},
)  # fmt: skip
GLTF = Dialect(
    {"diffuseColor": "base_color", "metallic": "metallic", "roughness": "roughness", "ior": "ior", "emissiveColor": "emissive",
     "opacity": "alpha", "clearcoat": "clearcoat", "clearcoatRoughness": "clearcoat_roughness"},
    {"diffuseColor": (1.0,) * 3, "metallic": (1.0,), "roughness": (1.0,), "clearcoatRoughness": (0.0,)},
    {"emissiveColor": {"emissive_strength": 1.0}},
)  # fmt: skip
OMNI_PBR = Dialect(
    {"diffuseColor": "diffuse_color_constant", "metallic": "metallic_constant", "roughness": "reflection_roughness_constant",
     "emissiveColor": "emissive_color", "opacity": "opacity_constant"},
    {"diffuseColor": (0.2,) * 3, "emissiveColor": (1.0, 0.1, 0.1)},
    {"emissiveColor": {"enable_emission": 0.0, "emissive_intensity": 40.0}},
)  # fmt: skip
DISNEY = Dialect(
    {"diffuseColor": "baseColor", "metallic": "metallic", "roughness": "roughness", "emissiveColor": "emitColor",
     "clearcoat": "clearcoat"},
    {"diffuseColor": (0.5,) * 3, "roughness": (0.25,)},
)  # fmt: skip
DIALECTS = {
    "UsdPreviewSurface": PREVIEW, "ND_UsdPreviewSurface_surfaceshader": PREVIEW,
    "ND_standard_surface_surfaceshader": STANDARD, "ND_standard_surface_surfaceshader_100": STANDARD,
    "standard_surface": STANDARD, "arnold:standard_surface": STANDARD, "ND_open_pbr_surface_surfaceshader": OPEN_PBR,
    "ND_gltf_pbr_surfaceshader": GLTF, "OmniPBR": OMNI_PBR, "PxrDisneyBsdf": DISNEY, "PxrDisney": DISNEY,
}  # fmt: skip
CONTEXTS = ["mtlx", "arnold", "mdl", "ri"]
"""Render contexts of other programs, by priority, if a material has no universal surface."""


def surface_of(material: UsdShade.Material) -> tuple[UsdShade.Shader | None, str, Dialect | None]:
    """Surface shader of a material, its identifier, and the names of its inputs if they are known."""
    first = material.ComputeSurfaceSource()[0]
    others = [material.ComputeSurfaceSource(context)[0] for context in CONTEXTS]
    found = [(each, _kind(each)) for each in (first, *others) if each]
    known = next(((each, kind) for each, kind in found if kind in DIALECTS), None)
    shader, kind = known or (found[0] if found else (None, ""))
    return shader, kind, DIALECTS.get(kind)


def _kind(shader: UsdShade.Shader) -> str:
    """Identifier of a shader, or its name within an MDL file."""
    return str(shader.GetIdAttr().Get() or shader.GetSourceAssetSubIdentifier("mdl") or "").partition("(")[0]
