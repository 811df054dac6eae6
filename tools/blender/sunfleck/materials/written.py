"""Materials of glTF from a `Surface`.

In go sources, out comes a material of the file. Invariant: factors lie in glTF's ranges; sources of one
texture in different pictures are combined in a new one, texel by texel.
"""

from dataclasses import replace

import numpy

from . import images as files
from .colours import rec709
from .pictures import OTHER_FILTERS
from .principled import Surface
from .sheets import unit
from .sources import BLACK, BRIGHTNESS, WHITE, Source

DEFAULTS = {
    "base": WHITE, "metallic": BLACK, "roughness": Source((0.5,) * 3), "ior": Source((1.5,) * 3), "specular": Source((0.5,) * 3),
    "specular_tint": WHITE, "transmission": BLACK, "coat": BLACK, "coat_roughness": BLACK, "sheen": BLACK, "sheen_roughness": BLACK,
    "sheen_tint": WHITE, "emission": WHITE, "emission_strength": BLACK, "thin": BLACK, "shine": WHITE,
}


class Writer:
    """Writes materials of a document. `uv_number` maps a name to its set of texture coordinates. Emission
    is multiplied by `exposure`."""

    def __init__(self, document, images, uv_number, exposure):
        self.document, self.images, self.uv_number, self.exposure = document, images, uv_number, exposure
        self.losses = []

    def material(self, name, surface: Surface, is_still=True):
        """Material without extras; its parameters may be animated unless `is_still`."""
        self.surface, self.is_still = surface, is_still
        self.losses = list(surface.losses)
        numbers = of_surface(surface, self.exposure)
        if max(rec709(self.source("base").factor)) > 1.0 + 1e-4:
            self.losses.append("base-above-one")
        if number_of(self.source("coat")) > 1.0:
            self.losses.append("coat-above-one")
        if number_of(self.source("emission_strength")) < 0.0:
            self.losses.append("emission-below-zero")
        pbr = {
            "baseColorFactor": numbers["base"],
            "metallicFactor": numbers["metallic"],
            "roughnessFactor": numbers["roughness"],
        }
        said = {"name": name, "pbrMetallicRoughness": pbr, "doubleSided": True}
        self.put(pbr, "baseColorTexture", self.base_texture())
        self.put(pbr, "metallicRoughnessTexture", self.metallic_roughness())
        self.put(said, "normalTexture", self.normal(surface.normal))
        self.put_emission(said, numbers)
        self.put_alpha(said, surface)
        extensions = dict(self.extensions())
        self.document.extensions.update(extensions)
        if extensions:
            said["extensions"] = extensions
        return said

    @staticmethod
    def put(owner, name, value):
        if value is not None:
            owner[name] = value

    def source(self, name):
        return self.surface.sources.get(name, DEFAULTS[name])

    def number(self, name):
        """Parameter that is one number in glTF; a picture counts by its mean."""
        return number_of(self.flat(name))

    def flat(self, name):
        source = self.source(name)
        if source.is_constant():
            return source
        self.losses.append(f"texture-of-{name.replace('_', '-')}")
        mean = 1.0
        if source.picture:
            pixels = self.images.pixels(source.picture)
            mean = 1.0 if pixels is None else channel_of(pixels, source.channel).mean(axis=(0, 1))
        return Source(tuple(numpy.broadcast_to(numpy.array(source.factor) * mean, 3).tolist()))

    # Textures.

    def info(self, picture, image, **more):
        """Texture info; None without an image."""
        if image is None:
            self.losses.append("image-unreadable")
            return None
        if picture.extension == "CLIP":
            self.losses.append("texture-clip")
        if picture.interpolation in OTHER_FILTERS:
            self.losses.append("texture-filter")
        said = {
            "index": files.texture(self.document, image, picture),
            "texCoord": self.uv_number(picture.uv),
            **more,
        }
        moved = {"offset": list(picture.offset), "rotation": picture.rotation, "scale": list(picture.scale)}
        rest = {"offset": [0.0, 0.0], "rotation": 0.0, "scale": [1.0, 1.0]}
        if moved != rest:
            self.document.extensions.add("KHR_texture_transform")
            said["extensions"] = {"KHR_texture_transform": moved}
        return said

    def base_texture(self):
        base, alpha = self.source("base"), self.surface.alpha
        if base.picture is None and alpha.picture is None:
            return None
        is_whole = base.picture and (
            alpha.picture is None or (alpha.picture == replace(base.picture, by_alpha="") and alpha.channel == 3)
        )
        if is_whole and base.channel == "rgb":
            self.check_range(base.picture)
            return self.info(base.picture, self.images.whole(base.picture, is_color=True))
        width, height = self.common_size(base, alpha)
        pixels = numpy.ones((height, width, 4), "f4")
        if base.picture:
            pixels[..., :3] = files.srgb(self.texels(base, width, height))
        if alpha.picture:
            pixels[..., 3] = self.texels(alpha, width, height, is_number=True)[..., 0]
        picture = base.picture or alpha.picture
        return self.info(picture, self.images.composed("base", pixels if alpha.picture else pixels[..., :3]))

    def check_range(self, picture):
        """Reports colours above 1 in float images, as the file is limited to 1."""
        is_float = getattr(picture.image, "is_float", False)
        pixels = self.images.pixels(picture) if is_float else None
        if pixels is not None and pixels[..., :3].max() > 1.0 + 1e-4:
            self.losses.append("picture-above-one")

    def metallic_roughness(self):
        metallic, roughness = self.source("metallic"), self.source("roughness")
        if metallic.picture is None and roughness.picture is None:
            return None
        picture = roughness.picture or metallic.picture
        usual = roughness.channel == 1 and metallic.channel == 2
        if usual and metallic.picture == roughness.picture and files.is_plain(picture.image):
            return self.info(picture, self.images.whole(picture, is_color=False))
        return self.info(picture, self.packed("metallic roughness", {1: roughness, 2: metallic}))

    def packed(self, name, sources):
        """Image with numbers in some channels, and 1 in the others."""
        width, height = self.common_size(*sources.values())
        pixels = numpy.ones((height, width, 3), "f4")
        for channel, source in sources.items():
            if source.picture:
                pixels[..., channel] = self.texels(source, width, height, is_number=True)[..., 0]
        return self.images.composed(name, pixels)

    def common_size(self, *sources):
        """Common size of the pictures for one texture."""
        sizes = [source.picture.image.size for source in sources if source.picture]
        return tuple(max(size[axis] for size in sizes) for axis in (0, 1))

    def texels(self, source, width, height, is_number=False):
        """Pixels of a source's picture at a size, by nearest neighbour."""
        pixels = self.images.pixels(source.picture)
        if pixels is None:
            return numpy.ones((height, width, 3), "f4")
        found = channel_of(pixels, source.channel)
        if found.size and found.max() > 1.0 + 1e-4:
            self.losses.append("picture-above-one")
        if is_number and found.shape[-1] == 3:
            found = channel_of(found, "grey")
        rows = ((numpy.arange(height) + 0.5) * found.shape[0] / height).astype(int)
        columns = ((numpy.arange(width) + 0.5) * found.shape[1] / width).astype(int)
        return found[rows][:, columns]

    def normal(self, found):
        if found is None:
            return None
        picture, strength = found
        pixels = self.images.pixels(picture) if 0.0 <= strength < 1.0 and self.is_still else None
        if pixels is not None:
            # Cycles interpolates towards the unbent normal; glTF scales x and y alone.
            weaker = 0.5 + 0.5 * (strength * (2.0 * pixels[..., :3] - 1.0) + (1.0 - strength) * numpy.array([0.0, 0.0, 1.0]))
            return self.info(picture, self.images.composed("normal", weaker, is_deep=True))
        return self.info(picture, self.images.whole(picture, is_color=False, is_deep=True), scale=strength)

    # Other parts.

    def put_emission(self, said, numbers):
        emission, strength = numbers["emission"], numbers["emission_strength"]
        source = self.source("emission")
        if strength == 0.0 or max(emission) == 0.0:
            return
        if source.picture:
            picture = source.picture
            self.check_range(picture)
            self.put(said, "emissiveTexture", self.info(picture, self.images.whole(picture, is_color=True)))
        said["emissiveFactor"] = emission

    def put_alpha(self, said, surface):
        if surface.cutoff is not None:
            said["alphaMode"], said["alphaCutoff"] = "MASK", surface.cutoff
        elif "filter" in surface.sources or not (surface.alpha.is_constant() and surface.alpha.number() >= 1.0):
            said["alphaMode"] = "BLEND"

    def extensions(self):
        """Names and values of extensions that differ from the defaults."""
        yield from self.strong_emission()
        ior = self.number("ior")
        if abs(ior - 1.5) > 1e-6:
            yield "KHR_materials_ior", {"ior": max(1.0, ior)}
        yield from self.specular()
        transmission = self.number("transmission")
        if transmission > 0.0:
            yield "KHR_materials_transmission", {"transmissionFactor": min(1.0, transmission)}
        yield from self.coat()
        yield from self.sheen()
        yield from self.through()

    def strong_emission(self):
        numbers = of_surface(self.surface, self.exposure)
        if numbers["emission_strength"] not in (0.0, 1.0) and max(numbers["emission"]) > 0.0:
            yield "KHR_materials_emissive_strength", {"emissiveStrength": numbers["emission_strength"]}

    def specular(self):
        """Specular extension. Cycles scales the reflectance along the normal by twice the level and by the
        tint, and reflects everything at grazing angles; a level of 0 reflects nothing."""
        level, tint, share = self.number("specular"), rec709(self.flat("specular_tint").factor), self.number("shine")
        if level == 0.0:
            yield "KHR_materials_specular", {"specularFactor": 0.0}
        elif (level, *tint, share) != (0.5, 1.0, 1.0, 1.0, 1.0):
            said = {"specularColorFactor": [2.0 * level * channel for channel in tint]}
            yield "KHR_materials_specular", said if share == 1.0 else {**said, "specularFactor": share}

    def coat(self):
        coat = self.source("coat")
        if coat.is_constant() and coat.number() == 0.0:
            return
        said = {
            "clearcoatFactor": min(1.0, max(0.0, self.number("coat"))),
            "clearcoatRoughnessFactor": min(1.0, self.number("coat_roughness")),
        }
        for channel, (name, ours) in enumerate((("clearcoat", "coat"), ("clearcoatRoughness", "coat_roughness"))):
            source, texture = self.source(ours), f"{name}Texture"
            if source.picture and source.attribute is None:
                self.losses.remove(f"texture-of-{ours.replace('_', '-')}")
                said[f"{name}Factor"] = min(1.0, number_of(source))
                self.put(said, texture, self.info(source.picture, self.packed(texture, {channel: source})))
        self.put(said, "clearcoatNormalTexture", self.normal(self.surface.coat_normal))
        yield "KHR_materials_clearcoat", said

    def sheen(self):
        weight = self.number("sheen")
        if weight > 0.0:
            tint = rec709(self.flat("sheen_tint").factor)
            color = [min(1.0, weight * channel) for channel in tint]
            roughness = min(1.0, self.number("sheen_roughness"))
            yield "KHR_materials_sheen", {"sheenColorFactor": color, "sheenRoughnessFactor": roughness}

    def through(self):
        """Diffuse transmission: glTF has one share for both, and a colour for each side."""
        through, share = self.surface.sources.get("through"), self.surface.share_through()
        if through is None or share == 0.0:
            return
        if max(through.factor) + max(self.source("base").factor) > 1.0 + 1e-3:
            self.losses.append("through-by-a-mask")
        said = {
            "diffuseTransmissionFactor": share,
            "diffuseTransmissionColorFactor": [unit(c / share) for c in rec709(through.factor)],
        }
        if through.picture:
            image = self.images.whole(through.picture, is_color=True)
            self.put(said, "diffuseTransmissionColorTexture", self.info(through.picture, image))
        yield "KHR_materials_diffuse_transmission", said


def channel_of(pixels, channel):
    """Channel of pixels (rows, columns, 3), or 1 for a single channel."""
    if channel == "grey":
        return (pixels[..., :3] @ numpy.array(BRIGHTNESS, "f4"))[..., None]
    return pixels[..., :3] if channel == "rgb" else pixels[..., channel : channel + 1]


def shines(surface):
    """Whether it is glossy: its gloss is then Cycles', which differs from glTF's own."""
    sources = (surface.sources.get(name, DEFAULTS[name]) for name in ("specular", "metallic", "coat"))
    return not all(source.is_zero() for source in sources)


def number_of(source):
    return float(source.number())


def of_surface(surface, exposure):
    """Parameters of a material that may change; emission is multiplied by `exposure`."""
    source = lambda name: surface.sources.get(name, DEFAULTS[name])
    # glTF subtracts the transmitted share from the reflected one.
    left = 1.0 - surface.share_through()
    color = [unit(channel / left) for channel in rec709(source("base").factor)]
    emission = [max(0.0, channel) for channel in rec709(source("emission").factor)]
    strength = exposure * max(0.0, number_of(source("emission_strength")))
    # Factors above 1 are scaled down and the strength up; weak emission needs no strength.
    largest = max(emission)
    if largest * strength <= 1.0:
        emission, strength = [channel * strength for channel in emission], 1.0 if strength else 0.0
    elif largest > 0.0:
        emission, strength = [channel / largest for channel in emission], strength * largest
    return {
        "base": [*color, unit(number_of(surface.alpha))],
        "metallic": unit(number_of(source("metallic"))),
        "roughness": unit(number_of(source("roughness"))),
        "emission": emission,
        "emission_strength": strength,
        "normal_scale": surface.normal[1] if surface.normal else None,
    }
