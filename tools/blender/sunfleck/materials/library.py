"""Materials of the file by index, one for each of Blender's and each set of names of texture coordinates.

In go materials and their geometries, out come indices. Invariant: every requested material has a sentence:
exact, or its losses.
"""


import bpy

from .. import extras
from ..film import of_cycles
from ..losses import Finding
from ..stored import by_hand
from ..evaluated.attributes import GENERATED
from ..evaluated.geometry import ATLAS
from ..evaluated.heeding import nobody
from . import bake, dependence, instances, sheets, stage
from .changes import Changes
from .colours import rec709
from .images import Images, has_codes
from .looks import DEFAULT, NOTHING, looked_at
from .sources import WHITE, NotSimple
from .written import Writer, shines

# Maximum number of meshes for which a material is baked; then its mean is used, as for meshes whose faces
# change in every frame.
MOST_MESHES = 64


class Library:
    """Materials of a document."""

    def __init__(self, exposure, is_still, frame):
        # Factor on emission. In a still, movies show their current frame, and nothing changes. Bakes are of a frame.
        self.exposure, self.is_still, self.frame = exposure, is_still, frame
        # Raises to cancel.
        self.heed = nobody
        self.looks, self.numbers, self.changes = {}, {}, Changes(exposure)
        # Of materials that differ from instance to instance: copies by facts, and how many levels
        # facts are rounded to.
        self.of_instances, self.copies, self.levels = {}, {}, {}
        # Both copies of materials whose sides differ.
        self.sides = {}

    def start(self, document, clock, shutter):
        """Materials go into this document from now on, their keys by this clock."""
        self.document, self.images = document, Images(document)
        self.changes.start(document, clock, shutter)

    def look(self, material):
        if material not in self.looks:
            if self.differs(material):
                # As representative as any other.
                one = self.copies[material, ()] = instances.copy(material, (), f"{material.name} 0")
                self.looks[one] = self.looks[material] = looked_at(one, self.is_still)
            else:
                self.looks[material] = looked_at(material, self.is_still)
            if material is not None and dependence.is_two_sided(material):
                self.sides[material] = tuple(self.side(material, is_back) for is_back in (False, True))
        return self.looks[material]

    def side(self, material, is_back):
        """Copy of a material for one side."""
        facts = ((instances.SIDE, (float(is_back),) * 4),)
        name = f"{material.name} ({'back' if is_back else 'front'})"
        made = self.copies[material, facts] = instances.copy(material, facts, name)
        if dependence.is_transparent(material):
            self.lose(made, dependence.SIDE)
        return made

    # What differs from instance to instance.

    def differs(self, material):
        """Questions of a material to each instance."""
        if material not in self.of_instances:
            self.of_instances[material] = {} if material is None else dependence.questions(material)
        return self.of_instances[material]

    def questions(self):
        """Questions of all materials to instances."""
        found = {question for material in bpy.data.materials for question in self.differs(material)}
        return tuple(sorted(found))

    def prepare(self, shown):
        """Finds the levels for rounding facts: `shown` counts materials and the facts of each instance at
        each frame."""
        found, changes = {}, {}
        for (material, facts), count in shown.items():
            if self.differs(material):
                found.setdefault(material, set()).add(instances.used(facts, self.differs(material)))
                changes[material] = changes.get(material, 0) + count
        for material, all_facts in found.items():
            is_few = not self.look(material).baked and changes[material] <= instances.MOST_CHANGES
            most = instances.MOST if is_few else instances.MOST_BAKED
            if len(all_facts) > most:
                self.levels[material] = instances.Levels(all_facts, most)

    def on_instance(self, material, facts):
        """Copy of a material for an instance."""
        if not self.differs(material):
            return material
        own = instances.used(facts, self.differs(material))
        if material in self.levels:
            own = self.levels[material].rounded(own)
        key = (material, own)
        if key not in self.copies:
            number = sum(one == material for one, _ in self.copies)
            self.copies[key] = instances.copy(material, own, f"{material.name} {number}")
        return self.copies[key]

    def close(self):
        """Removes all copies."""
        for made in self.copies.values():
            instances.remove(made)

    def lose(self, material, what):
        look = self.look(material)
        look.losses = sorted({*look.losses, what})

    def bend(self, material):
        """Marks a material of a deforming mesh, which is baked on one of its shapes."""
        if self.look(material).baked and dependence.is_of_shape(material):
            self.lose(material, "depends-on-shape")

    def is_seen(self, material):
        return self.look(material).surface is not None

    def attribute(self, material):
        """Colour attribute of a material and its part ("rgb", "rgba" or "a"); None without one."""
        surface = self.look(material).surface
        if surface is None:
            return None
        base, alpha = surface.sources.get("base", WHITE), surface.alpha
        if base.attribute is not None:
            return base.attribute, "rgba" if alpha.attribute == base.attribute else "rgb"
        return (alpha.attribute, "a") if alpha.attribute is not None else None

    def colors_of(self, material):
        """Names of the colour attributes that meshes need."""
        if self.look(material).baked:
            return sorted(dependence.colors_of(material) | ({GENERATED} if dependence.is_generated(material) else set()))
        found = self.attribute(material)
        return [] if found is None else [found[0]]

    def uvs_of(self, material):
        """Names of the texture coordinates that meshes need."""
        look = self.look(material)
        if look.baked:
            return dependence.uvs_of(material)
        return {picture.uv for picture in (look.surface or NOTHING).pictures() if picture.uv}

    def color_attribute(self, material, geometry):
        """This attribute, if the geometry has it."""
        found = self.attribute(material)
        return found if found is not None and found[0] in geometry.colors else None

    def wants_atlas(self, material, geometry):
        """Whether it is baked on the mesh itself, which then needs coordinates without overlap."""
        look = self.look(material)
        if not look.baked:
            return False
        uv = geometry.uv(dependence.uv_of(material))
        return uv is None or bool(uv.min() < -1e-5 or uv.max() > 1.00001) or dependence.is_of_surface(material)

    def number(self, material, geometry):
        """Index of the file's material."""
        order = tuple(geometry.uvs)
        canvas = self.canvas(material, geometry) if self.look(material).baked else None
        key = (material, order, canvas and canvas.key())
        if key not in self.numbers:
            self.numbers[key] = self.made(material, order, canvas)
        return self.numbers[key]

    def canvas(self, material, geometry):
        """Target of baking: the mesh, or the unit square of its texture coordinates."""
        if self.wants_atlas(material, geometry):
            return stage.Canvas(geometry, ATLAS, stage.size_on(geometry, dependence.has_lines(material)))
        uv = dependence.uv_of(material)
        sides = geometry.sides_m(uv) if dependence.has_bumps(material) else (1.0, 1.0)
        return stage.Canvas(None, uv, stage.size_of(dependence.largest_image(material)), sides)

    def made(self, material, order, canvas):
        look = self.look(material)
        uv_number = lambda name: order.index(name) if name in order else 0
        writer = Writer(self.document, self.images, uv_number, self.exposure)
        surface = self.baked(material, look, canvas) if look.baked else look.surface
        said = writer.material(material.name if material else "default", surface, material not in self.changes.watched)
        if canvas is None and surface.normal and any(
            uv_number(name) != uv_number(surface.normal[0].uv) for name in dependence.tangents_of(material)
        ):
            writer.losses.append("normal-map-uv")
        look.losses = sorted({*look.losses, *writer.losses})
        written = {**by_hand(material), **extras.of_material(material)} if material is not None else {}
        ours = {"principled": True} if shines(surface) or material in self.changes.glossy else {}
        if surface.shine_takes:
            ours["coat_takes"] = list(surface.shine_takes)
        if "normalTexture" in said and material is not None and of_cycles(material, "use_bump_map_correction", True):
            ours["bump_map_correction"] = True
        if any(has_codes(surface.sources[name].picture) for name in ("base", "emission") if name in surface.sources):
            ours["encoded_filtering"] = True
        if "thin" in surface.sources:
            share, ior = sheets.unit(writer.number("thin")), max(1.0, writer.number("ior"))
            one_face = {"one_face": True} if surface.has_one_face else {}
            ours["thin_dielectric"] = {"share": share, "ior": ior, **one_face}
        if surface.has_even_metal:
            ours["even_metal"] = True
        if "filter" in surface.sources:
            ours["filter_color"] = list(rec709(surface.sources["filter"].factor))
        if "metal" in surface.sources:
            ours["plain_metal"], ours["metal"] = True, list(rec709(surface.sources["metal"].factor))
        if ours:
            written["sunfleck_material"] = {**written.get("sunfleck_material", {}), **ours}
        if written:
            said["extras"] = written
        number = self.document.add("materials", said)
        self.changes.animate(material, number, said)
        look.glows |= "emissiveFactor" in said
        return number

    def baked(self, material, look, canvas):
        if look.bakes >= MOST_MESHES:
            look.losses = sorted({*look.losses, "mean-colours"})
            return look.mean
        try:
            surface = bake.Baker(material, canvas, self.frame, self.heed).surface()
        except (NotSimple, RuntimeError, TypeError) as error:
            look.failed = str(error.args[0].type if error.args and hasattr(error.args[0], "type") else error)
            return DEFAULT
        look.sizes.add(canvas.texels)
        look.bakes, look.mean = look.bakes + 1, look.mean or bake.mean_of(surface)
        return surface

    def words(self):
        """Sentence for every visible material: exact, baked with a number of texels, or not honoured."""
        found = {}
        for material, look in self.looks.items():
            if material is None or not self.is_shown(material):
                continue
            word = "not honoured" if look.failed else f"baked {look.texels}" if look.baked else "exact"
            found[material.name] = f"{word}, but for {', '.join(look.losses)}" if look.losses and not look.failed else word
        return found

    def findings(self):
        """Findings for every material that is not exact; keeps the names of all."""
        self.seen = {key[0].name if key[0] else "default" for key in self.numbers}
        yield from (
            Finding("instance-colors", f"the material `{material.name}`", f"{levels.count} levels")
            for material, levels in self.levels.items()
        )
        for material, look in self.looks.items():
            if material is None or (look.surface is None and not look.baked) or not self.is_shown(material):
                continue
            name = f"the material `{material.name}`"
            if look.failed:
                yield Finding("material-not-honoured", name, f"grey instead, for its node {look.failed}")
            elif look.baked:
                yield Finding("material-baked", name, f"{look.texels}, for its {look.baked}")
            if look.glows:
                yield Finding("material-glows", name)
            if look.losses:
                yield Finding("material-lost", name, ", ".join(look.losses))
            if not (self.is_still or self.changes.is_told(material, bool(look.baked))):
                yield Finding("material-changes", name)
        for material in () if self.is_still else self.changes.watched:
            if any(map(self.is_shown, self.copies_of(material))):
                yield Finding("material-changes", f"the material `{material.name}`")

    def copies_of(self, material):
        """Copies for sides and instances, and their copies."""
        for made in [made for (one, _), made in self.copies.items() if one == material]:
            yield made
            yield from self.copies_of(made)

    def is_shown(self, material):
        return any(key[0] == material for key in self.numbers)
