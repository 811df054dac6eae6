"""Baking of complex materials to pictures, by Cycles.

In go a material and a mesh to bake it on, out comes a `Surface` of baked pictures. Invariant: the scene is
restored: all temporary data are removed. Bakes of the same material on the same geometry at the same size
come from the cache.
"""

import os
from dataclasses import replace
from pathlib import Path

import bpy
import numpy

from ..evaluated.geometry import digest
from ..evaluated.heeding import nobody
from . import closures, dependence, instances, links, principled, sheets, sockets
from .colours import rec709, working_space
from .channels import COLORS, NUMBERS, SHINE, Channels, is_socket
from .fingerprint import of_tree
from .principled import Surface
from .sources import NotSimple, Picture, Source
from .stage import SAMPLES, Stage
from .written import DEFAULTS

# Counted up where the same tree comes to be baked otherwise: what was kept before is no longer looked at.
WAY = 7
# An alpha is a mask if so few texels are in between.
SOFT_SHARE = 0.02
# Minimum coverage of emission without a surface, for 8 bits, as alpha also scales light.
LEAST_COVER = 1.0 / 255.0


class Pixels:
    """Baked picture, with the interface of a Blender image."""

    def __init__(self, name, values):
        self.name, self.values_of_texels = name, values
        self.size = (values.shape[1], values.shape[0])


class Baker:
    """Bakes a material as at a frame; `heed` raises to cancel."""

    def __init__(self, material, canvas, frame, heed=nobody):
        self.material, self.canvas, self.frame, self.heed = material, canvas, frame, heed
        self.losses = []

    def surface(self):
        copy = self.material.copy()
        # Otherwise Cycles would limit normals by reflections here.
        copy.cycles.use_bump_map_correction = False
        try:
            tree = copy.node_tree
            output = principled.output_of(tree)
            channels = Channels(tree)
            parts = channels.of(links.link_to(output.inputs["Surface"]).from_socket)
            bends = channels.bends or links.link_to(output.inputs["Displacement"]) is not None
            pictures = self.pictures(copy, parts, bends)
            surface = self.put_together(pictures, channels)
            return glazed_in_part(surface, channels, parts.get(SHINE, 0.0)) or surface
        finally:
            instances.remove(copy)

    def pictures(self, copy, parts, bends):
        """Pixels of each part, constant or baked: (rows, columns, 3) or three numbers."""
        found = {name: spread(parts[name]) for name in (*COLORS, *NUMBERS) if not is_socket(parts[name])}
        baked = [name for name in COLORS if name not in found]
        baked += ["numbers"] if not found.keys() >= set(NUMBERS) else []
        baked += ["normal"] if bends else []
        if not baked:
            return found
        how = repr((WAY, SAMPLES, working_space(), bpy.app.version)).encode()
        key = digest(of_tree(self.material.node_tree, self.frame), self.canvas.key(), how)
        kept = folder() / f"{key.hex()}.npz"
        is_known = not dependence.is_of_film(self.material, dependence.OF_SEVERAL_FILES)
        if is_known and kept.is_file():
            with numpy.load(kept) as file:
                made = {name: file[name] for name in file.files}
        else:
            with Stage(copy, self.canvas, self.frame) as stage:
                made = {name: self.baked(stage, copy, name, parts) for name in baked}
            if is_known:
                keep(kept, made)
        if "numbers" in made:
            packed = made.pop("numbers")
            for at, name in enumerate(NUMBERS):
                found.setdefault(name, packed[..., at : at + 1].repeat(3, axis=-1))
        return {**found, **made}

    def baked(self, stage, copy, name, parts):
        self.heed()
        if name == "normal":
            return stage.bake("NORMAL")
        tree = copy.node_tree
        emission = tree.nodes.new("ShaderNodeEmission")
        output = principled.output_of(tree)
        before = links.link_to(output.inputs["Surface"]).from_socket
        if name == "numbers":
            combine = tree.nodes.new("ShaderNodeCombineColor")
            for socket, part in zip(combine.inputs, (parts[number] for number in NUMBERS)):
                Channels(tree).give(socket, part)
            tree.links.new(combine.outputs[0], emission.inputs["Color"])
        else:
            tree.links.new(parts[name], emission.inputs["Color"])
        ask_for_alpha(tree, emission)
        tree.links.new(emission.outputs[0], output.inputs["Surface"])
        found = stage.bake("EMIT")
        tree.links.new(before, output.inputs["Surface"])
        return found

    def put_together(self, pictures, channels):
        """Surface of the pictures; an emissive Principled BSDF keeps its other parameters."""
        glows = pictures["emission"].max(axis=-1, keepdims=True) > 0.0
        cover = numpy.where(glows, numpy.maximum(pictures["cover"], LEAST_COVER), pictures["cover"])
        there = numpy.maximum(cover, 1e-4)
        emission = pictures["emission"] / there
        if (pictures["reflected"] + pictures["through"] - cover).max() > 2e-3:
            self.losses.append("more-than-all")
        strength = float(emission.max()) or 0.0
        base, through = self.shared(*(numpy.minimum(pictures[name] / there, 1.0) for name in ("reflected", "through")))
        surface = Surface({
            "base": self.source("base", base),
            **{name: self.source(name, numpy.clip(pictures[name] / there, 0.0, 1.0)) for name in ("roughness", "metallic")},
            "emission": self.source("emission", emission / strength if strength else emission),
            "emission_strength": Source((strength,) * 3),
        })
        if pictures["through"].max() > 1e-4:
            surface.sources["through"] = self.source("through", through)
        surface.alpha = self.source("alpha", cover)
        is_sharp = float(((cover > 0.02) & (cover < 0.98)).mean()) < SOFT_SHARE and not (glows & (cover < 0.5)).any()
        if not surface.alpha.is_constant() and is_sharp:
            surface.cutoff = 0.5
        if "normal" in pictures:
            surface.normal = (self.picture("normal", 0.5 + 0.5 * pictures["normal"]), 1.0)
        self.add_shine(surface, channels.principled)
        if mixes_shine(channels):
            self.losses.append("mixed-shine")
        surface.has_even_metal = channels.metals == {"BSDF_GLOSSY"} and not channels.principled
        principled.scatter(surface)
        surface.losses = list(self.losses)
        return surface

    def shared(self, base, through):
        """Both, clamped where their largest channels add up to more than 1, as a file has one ratio for
        all texels."""
        both = base.max() + through.max()
        if both <= 1.0:
            return base, through
        cut = numpy.minimum(base, base.max() / both), numpy.minimum(through, through.max() / both)
        if sum(one.mean() for one in cut) < 0.99 * (base.mean() + through.mean()):
            self.losses.append("through-by-a-mask")
        return cut

    def add_shine(self, surface, shaders):
        if not shaders:
            metallic = surface.sources["metallic"]
            is_metal = not metallic.is_constant() or metallic.number() > 0.0
            surface.sources["specular"] = Source((0.5 if is_metal else 0.0,) * 3)
            return
        for name, socket in principled.SOCKETS.items():
            if name in surface.sources:
                continue
            try:
                source, *others = [sockets.of(shader.inputs[socket]) for shader in shaders]
                surface.sources[name] = source if source.is_constant() else DEFAULTS[name]
                if any(other != source for other in others):
                    self.losses.append("mixed-shine")
            except NotSimple:
                source = None
            if source is None or not source.is_constant():
                self.losses.append(f"texture-of-{name.replace('_', '-')}")

    def source(self, name, values):
        """Constant source if all texels are equal, else a picture."""
        if values.ndim == 1 or float(numpy.ptp(values, axis=(0, 1)).max()) < 1.0 / 512.0:
            return Source(tuple(map(float, values if values.ndim == 1 else values.mean(axis=(0, 1)))))
        values = rec709(values) if name not in {"roughness", "metallic", "alpha"} else values
        largest = float(values.max())
        return Source((largest,) * 3, self.picture(name, values / largest))

    def picture(self, name, values):
        pixels = numpy.concatenate([values, numpy.ones((*values.shape[:2], 1))], axis=-1).astype("f4")
        extension = "EXTEND" if self.canvas.geometry else "REPEAT"
        return Picture(Pixels(f"{self.material.name} {name}", pixels), self.canvas.uv, extension=extension)


def glazed_in_part(surface, channels, share):
    """Leaf with one uniform glaze, whose other share transmits all light; None for anything else."""
    is_leaf = len(channels.principled) == 1 and channels.mattes == {"BSDF_TRANSLUCENT"} and not (channels.metals or channels.adds)
    if not (is_leaf and 0.0 < share < 1.0 and closures.is_even_glaze(surface)):
        return None
    # The glaze's own, as Translucent BSDFs count as rough.
    rough, left = surface.sources["roughness"], 1.0 - share
    if rough.picture:
        texels = rough.factor[0] * rough.picture.image.values_of_texels
        rough = replace(rough, factor=(1.0,) * 3, picture=replace(rough.picture, image=Pixels(
            rough.picture.image.name, numpy.clip((texels - left) / share, 0.0, 1.0).astype("f4"))))
    else:
        rough = Source((max(0.0, rough.number() - left) / share,) * 3)
    sources = {**surface.sources, "roughness": rough, "shine": Source((share,) * 3)}
    return replace(surface, sources=sources, shine_takes=([1.0 / share] * 3, [0.0] * 3), losses=[one for one in surface.losses if one != "mixed-shine"])


def ask_for_alpha(tree, emission):
    """Adds a node that reads a picture's alpha, as Cycles then shows other colours; the reader may not be
    part of the bake."""
    before = None
    for node in [node for node in tree.nodes if node.type == "TEX_IMAGE" and node.outputs["Alpha"].is_linked]:
        asking = tree.nodes.new("ShaderNodeMath")
        # Practically 1, but not a constant that Cycles could fold.
        asking.operation, asking.inputs[1].default_value, asking.inputs[2].default_value = "MULTIPLY_ADD", 1e-30, 1.0
        tree.links.new(node.outputs["Alpha"], asking.inputs[0])
        if before:
            tree.links.new(before, asking.inputs[2])
        before = asking.outputs[0]
    if before:
        tree.links.new(before, emission.inputs["Strength"])


def mixes_shine(channels):
    """Whether shaders with different gloss are mixed, of which only one gloss remains."""
    shiny = [shader for shader in channels.principled if not all(sheets.is_zero(shader, name) for name in ("Specular IOR Level", "Metallic"))]
    told = {tuple(map(value_of, (shader.inputs["Metallic"], shader.inputs["Roughness"]))) for shader in channels.principled}
    kinds = len(channels.metals) + bool(channels.mattes) + bool(channels.principled)
    return bool(shiny or channels.metals) and (kinds > 1 or len(told) > 1 or channels.adds)


def value_of(socket):
    """What is linked to it, or its number."""
    link = links.link_to(socket)
    return (link.from_node.name, link.from_socket.identifier) if link else socket.default_value


def mean_of(surface):
    """Surface with the mean colours of its pictures, without mask and normal map."""

    def mean(source):
        if source.picture is None:
            return source
        pixels = source.picture.image.values_of_texels[..., :3].mean(axis=(0, 1))
        return Source(tuple(float(factor * pixel) for factor, pixel in zip(source.factor, pixels)))

    sources = {name: mean(source) for name, source in surface.sources.items()}
    return Surface(sources, alpha=mean(surface.alpha), losses=list(surface.losses))


def spread(part):
    return numpy.array(part if isinstance(part, tuple) else (part,) * 3, float)


def folder():
    """Folder of the cache."""
    caches = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    base = Path(os.environ.get("SUNFLECK_BAKES") or caches / "sunfleck" / "bakes")
    base.mkdir(parents=True, exist_ok=True)
    return base


def keep(path, made):
    """Writes a file, whole or not at all."""
    beside = path.with_name(f"{path.stem}.{os.getpid()}.tmp.npz")
    numpy.savez(beside, **made)
    beside.replace(path)
