"""Conversion of a stage's textures to glTF's: unchanged where glTF can represent them, else baked into new
ones.

In go sources of inputs (`Fed`), out come factors and the texture that they multiply. Invariant: factor
times texel equals the stage's value to half of a 255th; clipped, reduced or averaged textures are
reported. glTF's base colour and emission are sRGB, all else is linear.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...gltf.writer import GlbWriter
from ...srgb import srgb_from_linear
from .losses import Losses
from .networks import Fed
from .planes import Planes
from .texels import Picture, png
from .textures import Placement, Texture, Textures

NORMALS = ((2.0, 2.0, 2.0, 1.0), (-1.0, -1.0, -1.0, 0.0))
"""Scale and bias of a normal map, the alpha's apart: the only ones that glTF has."""
MIME = {"PNG": "image/png", "JPEG": "image/jpeg"}


class Bakery:
    """Writes the textures of one stage, equal ones once."""

    def __init__(self, writer: GlbWriter, textures: Textures, lost: Losses):
        self.writer, self.textures, self.lost = writer, textures, lost
        self.planes = Planes(textures, lost)
        self._images: dict[object, int] = {}

    def color(self, rgb: Fed, alpha: Fed) -> tuple[list[float], dict | None]:
        """Base colour and opacity: four factors, and an sRGB texture with alpha."""
        rgb, alpha = self._readable([rgb, alpha])
        if rgb.texture is None and alpha.texture is None:
            return [*_shares(rgb.numbers), *_shares(alpha.numbers)], None
        shines_through = alpha.texture is not None or alpha.numbers[0] < 1
        if rgb.texture is not None and self._is_color(rgb, most=1.0):
            picture = self._picture(rgb.texture)
            is_same = alpha.texture is not None and self._is_alpha_of(alpha, rgb.texture)
            if is_same or not shines_through or (alpha.texture is None and picture.channels in (1, 3)):
                scale = alpha.texture.scale[3] if alpha.texture is not None else 1.0
                factors = _shares([each * by for each, by in zip(rgb.numbers, rgb.texture.scale)])
                return [*factors, alpha.numbers[0] * scale], self._info(rgb.texture)
        parts = [(rgb, True)] if rgb.texture is not None else []
        parts += [(alpha, False)] if alpha.texture is not None else []
        key, planes, placement = self.planes.read(
            [part for part, _ in parts], [is_color for _, is_color in parts]
        )
        factors = [1.0] * 3 if rgb.texture is not None else [*_shares(rgb.numbers)]
        even = np.ones((*planes[0].shape[:2], 3), np.float32)
        colors = even if rgb.texture is None else planes.pop(0)[..., :3]
        baked = [srgb_from_linear(self._clipped(colors, rgb.texture or alpha.map))]
        if alpha.texture is not None:
            baked.append(self._clipped(planes.pop(0)[..., :1], alpha.map))
        factors.append(1.0 if alpha.texture is not None else alpha.numbers[0])
        return factors, self._baked(("color", key), np.concatenate(baked, axis=-1), placement)

    def emission(self, rgb: Fed) -> tuple[list[float], dict | None]:
        """Three factors of any size, and an sRGB texture."""
        (rgb,) = self._readable([rgb])
        if rgb.texture is None:
            return [max(each, 0.0) for each in rgb.numbers], None
        if self._is_color(rgb, most=np.inf):
            return [each * by for each, by in zip(rgb.numbers, rgb.texture.scale)], self._info(rgb.texture)
        key, (colors,), placement = self.planes.read([rgb], [True])
        colors = np.maximum(colors[..., :3], 0)
        brightest = max(float(colors.max()), 1.0)
        if brightest > 1:
            what = f"emission up to {brightest:.4g} has 256 steps a channel"
            self.lost.add("usd-texture-range", rgb.texture.place, what)
        return [brightest] * 3, self._baked(
            ("emission", key), srgb_from_linear(colors / brightest), placement
        )

    def flat(self, fed: Fed) -> tuple[float, ...]:
        """Factors where glTF has no texture that is honoured: the mean of the texture."""
        if fed.texture is None:
            return fed.numbers
        what = "its mean stands for a texture: glTF has no place for it"
        self.lost.add("usd-texture-packing", fed.texture.place, what)
        return self.planes.mean(fed)

    def shares(self, slots: dict[int, Fed]) -> tuple[dict[int, float], dict | None]:
        """Values from 0 to 1 in channels (0 red, 1 green, 2 blue) of one linear texture: a factor each,
        and the texture."""
        slots = dict(zip(slots, self._readable(list(slots.values()))))
        textured = {slot: fed for slot, fed in slots.items() if fed.texture is not None}
        factors = {slot: _shares(fed.numbers)[0] for slot, fed in slots.items()}
        if not textured:
            return factors, None
        if self._is_packed(slots, textured):
            for slot, fed in textured.items():
                factors[slot] = fed.numbers[0] * fed.map.scale[slot]
            return factors, self._info(next(iter(textured.values())).map)
        key, planes, placement = self.planes.read(list(textured.values()), [False] * len(textured))
        packed = np.ones((*planes[0].shape[:2], 3), np.float32)
        for (slot, fed), plane in zip(textured.items(), planes):
            packed[..., slot] = self._clipped(plane[..., 0], fed.map)
            factors[slot] = 1.0
        return factors, self._baked(("shares", tuple(textured), key), packed, placement)

    def normal(self, fed: Fed) -> dict | None:
        """A normal map in the tangent space of glTF."""
        if fed.texture is None or fed.texture.placement.layer < 0:
            return None
        texture = fed.texture
        is_bare = texture.bias is None and texture.scale == (1.0,) * 4
        if is_bare and self._picture(texture).bits < 32:
            what = "a normal map without scale and bias is taken as one from -1 to 1"
            self.lost.add("usd-normal-map", texture.place, what)
            texture = replace(texture, scale=NORMALS[0], bias=NORMALS[1])
        is_usual = texture.scale[:3] == NORMALS[0][:3] and (texture.bias or ())[:3] == NORMALS[1][:3]
        if is_usual and texture.space != "sRGB" and self._is_carried(texture) and fed.output == "rgb":
            return self._info(texture)
        key, (normals,), placement = self.planes.read([replace(fed, texture=texture)], [False])
        return self._baked(("normal", key), 0.5 * normals[..., :3] + 0.5, placement)

    def _readable(self, inputs: list[Fed]) -> list[Fed]:
        """Inputs whose textures fit into one picture; those with other placements, or without coordinates,
        become their mean."""
        placements = (fed.map.placement for fed in inputs if fed.texture is not None)
        first = next((each for each in placements if each.layer >= 0), None)
        return [
            fed if fed.texture is None or fed.texture.placement == first else self._mean(fed)
            for fed in inputs
        ]

    def _mean(self, fed: Fed) -> Fed:
        why = "it lies elsewhere than another that it has to be packed with"
        if fed.map.placement.layer < 0:
            why = "the mesh has no coordinates for it"
        self.lost.add("usd-texture-packing", fed.map.place, f"its mean stands for a texture: {why}")
        return Fed(self.planes.mean(fed))

    def _picture(self, texture: Texture) -> Picture:
        return self.textures.picture(texture.files[0][1])

    def _is_carried(self, texture: Texture) -> bool:
        return len(texture.files) == 1 and texture.files[0][0] == (0, 0) and self._picture(texture).is_carried

    def _is_color(self, fed: Fed, most: float) -> bool:
        """Whether glTF can represent it unchanged."""
        texture = fed.map
        is_scaled = texture.bias is None or not any(texture.bias[:3])
        in_range = all(0 <= each <= most for each in texture.scale[:3])
        is_plain = self._is_carried(texture) and fed.output == "rgb" and self.planes.is_srgb(texture, True)
        return is_plain and is_scaled and in_range

    def _is_alpha_of(self, alpha: Fed, other: Texture) -> bool:
        texture = alpha.map
        is_plain = (texture.bias is None or not texture.bias[3]) and 0 <= texture.scale[3] <= 1
        is_beside = (texture.files, texture.placement) == (other.files, other.placement)
        return alpha.output == "a" and is_plain and is_beside

    def _is_packed(self, slots: dict[int, Fed], textured: dict[int, Fed]) -> bool:
        """Whether a file has its values in glTF's channels, and inputs without a texture are 0."""
        textures = [fed.map for fed in textured.values()]
        files = {(texture.files, texture.placement) for texture in textures}
        if len(files) > 1 or not self._is_carried(textures[0]):
            return False
        if any(fed.numbers[0] != 0 for slot, fed in slots.items() if slot not in textured):
            return False
        for slot, fed in textured.items():
            texture, bias = fed.map, fed.map.bias
            in_range = (bias is None or not bias[slot]) and 0 <= texture.scale[slot] <= 1
            if not in_range or self.planes.is_srgb(texture, False) or fed.output != "rgb"[slot]:
                return False
        return True

    def _clipped(self, values: np.ndarray, texture: Texture) -> np.ndarray:
        if values.min() < -1e-3 or values.max() > 1 + 1e-3:
            said = f"its numbers go from {values.min():.4g} to {values.max():.4g}, and are clipped to 0 and 1"
            self.lost.add("usd-texture-range", texture.place, said)
        return np.clip(values, 0, 1)

    def _info(self, texture: Texture) -> dict:
        """Texture info of an unchanged file."""
        picture = self._picture(texture)
        if picture.path not in self._images:
            name = picture.path.replace("[", "/").rstrip("]").rpartition("/")[2].rpartition(".")[0]
            image = {
                "name": name,
                "mimeType": MIME[picture.form],
                "bufferView": self.writer.view(picture.data),
            }
            self._images[picture.path] = self.writer.add("images", image)
        return self._placed_image(self._images[picture.path], texture.placement)

    def _baked(self, key: object, texels: np.ndarray, placement: Placement) -> dict:
        if key not in self._images:
            name = f"baked {len(self._images)}"
            image = {"name": name, "mimeType": MIME["PNG"], "bufferView": self.writer.view(png(texels))}
            self._images[key] = self.writer.add("images", image)
        return self._placed_image(self._images[key], placement)

    def _placed_image(self, image: int, placement: Placement) -> dict:
        wraps = {"wrapS": placement.wraps[0], "wrapT": placement.wraps[1]}
        texture = {"source": image, "sampler": self._known("samplers", wraps)}
        info: dict = {"index": self._known("textures", texture), "texCoord": placement.layer}
        if placement.moved is not None:
            offset, rotation, scale = placement.moved
            self.writer.extensions.add("KHR_texture_transform")
            moved = {"offset": list(offset), "rotation": rotation, "scale": list(scale)}
            info["extensions"] = {"KHR_texture_transform": moved}
        return info

    def _known(self, kind: str, value: dict) -> int:
        values = self.writer.document.setdefault(kind, [])
        if value not in values:
            values.append(value)
        return values.index(value)


def _shares(numbers: Sequence[float]) -> list[float]:
    return [min(max(each, 0.0), 1.0) for each in numbers]
