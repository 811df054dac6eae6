"""What of a scene will be lost on the way to sunfleck, or cannot be exported at all.

In goes a scene, out come findings; an error stands in the way of export, a warning does not.
"""

from dataclasses import dataclass

from . import world

LOST_SHADERS = {
    "BSDF_TRANSLUCENT": "a translucent BSDF: mark the material as a leaf in the panel instead",
    "SUBSURFACE_SCATTERING": "subsurface scattering",
    "HOLDOUT": "a holdout",
    "BSDF_HAIR": "a hair BSDF",
    "BSDF_HAIR_PRINCIPLED": "a hair BSDF",
    "BSDF_TOON": "a toon BSDF",
}


@dataclass
class Finding:
    severity: str  # "ERROR" or "WARNING", as Blender's reports
    message: str


def check(scene):
    """Everything found, errors first."""
    found = [*of_scene(scene)]
    materials = set()
    for thing in scene.objects:
        if thing.hide_render and not is_hidden_at_times(thing):
            continue
        found += of_object(thing)
        materials.update(slot.material for slot in thing.material_slots if slot.material)
        if thing.type == "MESH" and not thing.sunfleck_settings.is_fog and any(
            slot.material and has_volume(slot.material) for slot in thing.material_slots
        ):
            yes = f"`{thing.name}` has a volume material, which becomes an opaque box: tick Holds fog in its panel"
            found.append(Finding("ERROR", yes))
    for material in materials:
        found += of_material(material)
    return sorted(found, key=lambda finding: finding.severity != "ERROR")


def warn(message):
    return Finding("WARNING", message)


def of_scene(scene):
    if scene.camera is None:
        yield warn("the scene has no active camera: sunfleck takes the first, or makes one up")
    if abs(scene.unit_settings.scale_length - 1.0) > 1e-6:
        yield warn("the unit scale is not exported: one Blender unit is one metre")
    own = scene.sunfleck_settings
    if own.use_world:
        yield from map(warn, world.losses(scene))
    elif own.background_strength == 0.0 and world.shines(scene):
        yield warn("the world is not exported: tick World as sky in the panel, or give a background and a sun for its light")


def of_object(thing):
    name = f"`{thing.name}`"
    if thing.type == "LIGHT":
        yield from of_light(name, thing.data)
    if thing.type == "CAMERA" and thing.data.type not in {"PERSP", "ORTHO"}:
        yield warn(f"{name}: panoramic cameras are not exported")
    if thing.type == "VOLUME":
        yield warn(f"{name}: volumes from files are not exported")
    if any(system.settings.render_type in {"OBJECT", "COLLECTION"} for system in thing.particle_systems):
        yield warn(f"{name}: particle instances are not exported: make them real (Object > Apply > Make Instances Real)")
    for constraint in thing.constraints:
        if constraint.type == "CHILD_OF" and not constraint.mute and not is_uniform(constraint.target):
            yield warn(f"{name}: a Child Of constraint to an uneven scale shears, which is not exported: parent it instead")


def is_uniform(target):
    if target is None:
        return True
    x, y, z = target.matrix_world.to_scale()
    return max(x, y, z) - min(x, y, z) < 1e-6


def of_light(name, light):
    # The exporter fails on both of these.
    if light.use_temperature:
        yield Finding("ERROR", f"{name}: Blender's exporter fails on a colour temperature: set the colour instead")
    if not light.normalize:
        yield Finding("ERROR", f"{name}: Blender's exporter fails on lights that are not normalised: tick Normalize")
    if light.energy < 0.0:
        yield Finding("ERROR", f"{name}: a light's power is negative")
    if light.type == "AREA" and light.spread < 3.14:
        yield warn(f"{name}: the spread of an area light is not honoured")
    if light.node_tree and light.use_nodes and any(node.type != "OUTPUT_LIGHT" for node in light.node_tree.nodes):
        yield warn(f"{name}: light nodes are exported only in part: use the light's own power and colour")


def of_material(material):
    name = f"the material `{material.name}`"
    for node in nodes_of(material):
        lost = LOST_SHADERS.get(node.type)
        if lost and not (node.type == "BSDF_TRANSLUCENT" and material.sunfleck_settings.is_leaf):
            yield warn(f"{name} loses {lost}")


def changes(material):
    """Whether anything of a material is keyed or driven."""
    owners = [material, material.node_tree] if material.node_tree else [material]
    data = [owner.animation_data for owner in owners if owner.animation_data]
    return any(one.action or one.drivers for one in data)


def nodes_of(material):
    return material.node_tree.nodes if material.node_tree else []


def has_volume(material):
    outputs = [node for node in nodes_of(material) if node.type == "OUTPUT_MATERIAL"]
    return any(node.inputs["Volume"].is_linked and not node.inputs["Surface"].is_linked for node in outputs)


def is_hidden_at_times(thing):
    data = thing.animation_data
    return bool(data and any(curve.data_path == "hide_render" for curve in curves(data)))


def curves(animation_data):
    """The F-curves of an action's slot, and its drivers."""
    yield from animation_data.drivers
    action = animation_data.action
    for layer in action.layers if action else ():
        for strip in layer.strips:
            bag = strip.channelbag(animation_data.action_slot) if animation_data.action_slot else None
            yield from bag.fcurves if bag else ()
