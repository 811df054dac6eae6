"""Materials as UsdPreviewSurface, with their textures
(https://openusd.org/release/spec_usdpreviewsurface.html)."""

import math

from pxr import Gf, Sdf

from ..gltf.scene import Gltf
from ..gltf.values import Value
from .prims import Names, Prim, Types, texture_coordinates
from .textures import Textures

OURS = ("sunfleck_leaf", "sunfleck_material")
WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
NOT_CARRIED = ("KHR_materials_transmission", "KHR_materials_diffuse_transmission")


class Materials:
    """Writes each material once; prims refer to it by a copy that their own instances can see."""

    def __init__(self, gltf: Gltf, names: Names, library: Prim, textures: Textures, lost: list[str]):
        self.sources = gltf.document.items("materials")
        self.texture_sources = gltf.document.items("textures")
        self.samplers = gltf.document.items("samplers")
        self.names, self.library, self.textures, self.lost = names, library, textures, lost
        self._written: dict[int, Prim] = {}

    def refer(self, holder: Prim, number: int) -> Sdf.Path:
        """Material below `holder` that refers to material `number`."""
        if number not in self._written:
            source = self.sources[number]
            name = self.names.new(source.text_at("name") or f"material {number}")
            self._written[number] = self._write(self.library.child(name, "Material"), source)
        written = self._written[number]
        # The name may be the same below each holder, as paths differ.
        prim = holder.child(written.spec.name, "Material")
        prim.refer_to(written.path)
        return prim.path

    def _write(self, prim: Prim, source: Value) -> Prim:
        Surface(self, prim, source).write()
        extras = source.extras.raw
        ours = {name: extras[name] for name in OURS if isinstance(extras.get(name), dict)}
        for name in NOT_CARRIED:
            if (extension := source.extension(name)) is not None:
                ours[name] = extension.raw
                self.lost.append(
                    f"what {name} says is kept as custom data alone: UsdPreviewSurface has no word for it"
                )
        if source.text_at("alphaMode", "OPAQUE") == "BLEND":
            # An opacity of 1 does not show that the material blends, as filters do.
            ours["alpha_mode"] = "BLEND"
        normal = source.member("normalTexture")
        if normal is not None and normal.number_at("scale", 1.0) != 1.0:
            ours["normal_scale"] = normal.number_at("scale", 1.0)
            self.lost.append(
                "strengths of normal maps are kept as custom data alone: UsdPreviewSurface has only one"
            )
        prim.remember(ours)
        if any(name in ours for name in OURS):
            self.lost.append(
                "light through leaves, filters and mirrors are kept as custom data alone: UsdPreviewSurface "
                "has no word for it"
            )
        return prim


class Surface:
    """Network of one material."""

    def __init__(self, materials: Materials, prim: Prim, source: Value):
        self.materials, self.prim, self.source = materials, prim, source
        self.readers: dict[int, Sdf.Path] = {}
        self.shader = self._node("surface", "UsdPreviewSurface")

    def _node(self, name: str, kind: str) -> Prim:
        """Shader of one of USD's kinds."""
        node = self.prim.child(name, "Shader")
        node.set("info:id", Types.Token, kind, uniform=True)
        return node

    def write(self) -> None:
        """Writes the shader, textures and readers of texture coordinates."""
        shader, source = self.shader, self.source
        pbr = source.group("pbrMetallicRoughness")
        red, green, blue, alpha = pbr.numbers_at("baseColorFactor", 1.0, 1.0, 1.0, 1.0)
        base = pbr.member("baseColorTexture")
        # An unlit material emits its base colour, and is black otherwise.
        is_unlit = source.extension("KHR_materials_unlit") is not None
        shown = "inputs:emissiveColor" if is_unlit else "inputs:diffuseColor"
        if base is None:
            shader.set(shown, Types.Color3f, Gf.Vec3f(red, green, blue))
        else:
            texture = self._texture("base_color", base, (red, green, blue, alpha))
            self._feed(shown, Types.Color3f, texture, "rgb", Types.Float3)
        if is_unlit:
            shader.set("inputs:diffuseColor", Types.Color3f, Gf.Vec3f(0))
        mode = source.text_at("alphaMode", "OPAQUE")
        if mode != "OPAQUE":
            if base is None:
                shader.set("inputs:opacity", Types.Float, alpha)
            else:
                self._feed("inputs:opacity", Types.Float, texture, "a", Types.Float)
            if mode == "MASK":
                shader.set(
                    "inputs:opacityThreshold", Types.Float, source.number_at("alphaCutoff", 0.5, 0.0, 1.0)
                )
        self._write_coat(pbr, is_unlit)
        if not is_unlit:
            self._write_emission()
        normal = source.member("normalTexture")
        if normal is not None:
            # UsdPreviewSurface allows no other scale of normal maps.
            texture = self._texture("normal", normal, (2, 2, 2, 1), (-1, -1, -1, 0), is_color=False)
            self._feed("inputs:normal", Types.Normal3f, texture, "rgb", Types.Float3)
        shader.set("outputs:surface", Types.Token, None)
        self.prim.connect("outputs:surface", Types.Token, shader.path.AppendProperty("outputs:surface"))

    def _write_coat(self, pbr: Value, is_unlit: bool) -> None:
        shader = self.shader
        factors = (pbr.number_at(f"{name}Factor", 1.0, 0, 1) for name in ("roughness", "metallic"))
        roughness, metallic = factors
        both = pbr.member("metallicRoughnessTexture")
        if both is None:
            shader.set("inputs:roughness", Types.Float, roughness)
            shader.set("inputs:metallic", Types.Float, metallic)
        else:
            texture = self._texture("metallic_roughness", both, (1, roughness, metallic, 1), is_color=False)
            self._feed("inputs:roughness", Types.Float, texture, "g", Types.Float)
            self._feed("inputs:metallic", Types.Float, texture, "b", Types.Float)
        shader.set("inputs:useSpecularWorkflow", Types.Int, 0)
        shader.set("inputs:ior", Types.Float, 1.0 if is_unlit else self._ior())
        coat = self.source.extension("KHR_materials_clearcoat")
        if coat is not None:
            for name in ("clearcoat", "clearcoatRoughness"):
                shader.set(f"inputs:{name}", Types.Float, coat.number_at(f"{name}Factor", 0.0, 0, 1))

    def _ior(self) -> float:
        """Refractive index whose reflectance along the normal is that of glTF's index, factor and colour
        together."""
        described = self.source.extension("KHR_materials_ior")
        specular = self.source.extension("KHR_materials_specular")
        index = 1.5 if described is None else described.number_at("ior", 1.5, 1.0, 100.0)
        factor = 1.0
        if specular is not None:
            factor = specular.number_at("specularFactor", 1.0, 0, 1)
            factor *= sum(specular.numbers_at("specularColorFactor", 1.0, 1.0, 1.0)) / 3
        reflected = min(((index - 1) / (index + 1)) ** 2 * factor, 0.99)
        return (1 + math.sqrt(reflected)) / (1 - math.sqrt(reflected))

    def _write_emission(self) -> None:
        strength = self.source.extension("KHR_materials_emissive_strength")
        scale = 1.0 if strength is None else strength.number_at("emissiveStrength", 1.0, 0)
        red, green, blue = (scale * each for each in self.source.numbers_at("emissiveFactor", 0.0, 0.0, 0.0))
        picture = self.source.member("emissiveTexture")
        if picture is not None:
            texture = self._texture("emission", picture, (red, green, blue, 1))
            self._feed("inputs:emissiveColor", Types.Color3f, texture, "rgb", Types.Float3)
        elif max(red, green, blue) > 0:
            self.shader.set("inputs:emissiveColor", Types.Color3f, Gf.Vec3f(red, green, blue))

    def _feed(
        self, name: str, kind: Sdf.ValueTypeName, texture: Prim, output: str, output_kind: Sdf.ValueTypeName
    ) -> None:
        if f"outputs:{output}" not in texture.spec.attributes:
            texture.set(f"outputs:{output}", output_kind, None)
        self.shader.connect(name, kind, texture.path.AppendProperty(f"outputs:{output}"))

    def _texture(self, name: str, info: Value, scale, bias=(0, 0, 0, 0), is_color: bool = True) -> Prim:
        owner = self.materials
        texture = info.need("index").item_of(owner.texture_sources, "texture")
        prim = self._node(name, "UsdUVTexture")
        prim.set("inputs:file", Types.Asset, Sdf.AssetPath(owner.textures.file_of(texture)))
        prim.set("inputs:sourceColorSpace", Types.Token, "sRGB" if is_color else "raw")
        prim.set("inputs:scale", Types.Float4, Gf.Vec4f(*scale))
        if any(bias):
            prim.set("inputs:bias", Types.Float4, Gf.Vec4f(*bias))
        sampler = texture.member("sampler")
        wraps = (
            Value({}, texture.file) if sampler is None else sampler.item_of(owner.samplers, "sampler")
        )
        for axis in "ST":
            wrap = WRAPS.get(int(wraps.number_at(f"wrap{axis}", 10497)), "repeat")
            prim.set(f"inputs:wrap{axis}", Types.Token, wrap)
        transform = info.extension("KHR_texture_transform")
        layer = int(info.number_at("texCoord", 0, 0, 7))
        if transform is not None:
            layer = int(transform.number_at("texCoord", layer, 0, 7))
        source = self._reader(layer)
        if transform is not None:
            source = self._transform(name, transform, source)
        prim.connect("inputs:st", Types.Float2, source)
        return prim

    def _reader(self, layer: int) -> Sdf.Path:
        """Reader of a set of texture coordinates."""
        if layer not in self.readers:
            name = texture_coordinates(layer)
            prim = self._node(f"read_{name}", "UsdPrimvarReader_float2")
            prim.set("inputs:varname", Types.String, name)
            prim.set("outputs:result", Types.Float2, None)
            self.readers[layer] = prim.path.AppendProperty("outputs:result")
        return self.readers[layer]

    def _transform(self, name: str, transform: Value, source: Sdf.Path) -> Sdf.Path:
        """glTF rotates clockwise about the upper left corner, USD anticlockwise about the lower left one."""
        (u, v), (wide, high) = transform.numbers_at("offset", 0, 0), transform.numbers_at("scale", 1, 1)
        angle = transform.number_at("rotation", 0.0)
        prim = self._node(f"{name}_place", "UsdTransform2d")
        prim.connect("inputs:in", Types.Float2, source)
        prim.set("inputs:scale", Types.Float2, Gf.Vec2f(wide, high))
        prim.set("inputs:rotation", Types.Float, math.degrees(angle))
        place = (u + high * math.sin(angle), 1 - v - high * math.cos(angle))
        prim.set("inputs:translation", Types.Float2, Gf.Vec2f(*place))
        prim.set("outputs:result", Types.Float2, None)
        return prim.path.AppendProperty("outputs:result")
