"""Check of a scene's settings for features that sunfleck lacks.

In goes a scene, out come findings (`losses`); the export adds those that settings do not show. Invariant:
every feature that Blender renders and sunfleck does not is among them.
"""

from . import extras, film, fog, nearness, volumes, world
from .evaluated import lights, simulations, walk
from .film import is_a_portal, of_cycles
from .keys import curves_of
from .losses import Finding, ordered
from .materials import colours, dependence, links, principled


def check(scene):
    """All findings, errors first."""
    return ordered([*of_scene(scene), *of_cameras(scene), *of_objects(list(rendered(scene)), scene)])


def of_shown(things, scene):
    """Findings of objects that only nodes or a background set show; `things` are all that an export saw."""
    settled = set(rendered(scene))
    return of_objects([thing for thing in things if thing not in settled], scene)


def of_objects(things, scene):
    found, materials = [], set()
    for thing in things:
        found += of_object(thing, scene)
        if not (thing.sunfleck_settings.is_fog or thing.type == "VOLUME"):
            materials.update(slot.material for slot in thing.material_slots if slot.material)
    for material in sorted(materials, key=lambda material: material.name):
        found += of_material(material, scene.sunfleck_settings)
    return found


def rendered(scene):
    """Objects that render at some frame, with those of instanced collections."""
    return simulations.with_instanced(scene.objects, lambda thing: not thing.hide_render or is_hidden_at_times(thing))


def of_scene(scene):
    render, layer = scene.render, walk.view_layer(scene)
    said = {
        "no-camera": scene.camera is None,
        "unit-scale": abs(scene.unit_settings.scale_length - 1.0) > 1e-6,
        "border": render.use_border,
        "pixel-aspect": render.pixel_aspect_x != render.pixel_aspect_y,
        "film-exposure-changes": film.changes(scene),
        "frame-step": scene.frame_step != 1,
        "view-layers": sum(layer.use for layer in scene.view_layers) > 1,
        "stereo": render.use_multiview,
        "compositor": render.use_compositing and getattr(scene, "compositing_node_group", None) is not None,
        "sequencer": render.use_sequencer and bool(scene.sequence_editor and scene.sequence_editor.strips_all),
        "freestyle": render.use_freestyle,
        "color-overrides": layer.world_override is not None or (layer.material_override is not None and has_fog(scene)),
        "layer-filters": not all(getattr(layer, part) for part in LAYER_PARTS) or (render.use_motion_blur and not layer.use_motion_blur),
        "camera-culling": render.use_simplify and any(of_cycles(scene, by, False) for by in ("use_camera_cull", "use_distance_cull")),
        "world-volume": world.volume_of(scene) is not None and fog.of_world(scene) is None,
        "world-rays": bool(scene.world) and not all(of_cycles(scene.world, rays, True, "cycles_visibility") for rays in WORLD_RAYS),
        "shutter-changes": render.use_motion_blur and any(curve.data_path.startswith("render.motion_blur") for curve in curves_of(scene)),
        "shutter-shape": render.use_motion_blur and not is_box(scene),
        "working-space": colours.working_space() != "Linear Rec.709",
        "view-transform": not extras.is_shown_alike(scene.view_settings),
    }
    yield from (Finding(id) for id, is_so in said.items() if is_so)
    own, everywhere = scene.sunfleck_settings, fog.of_world(scene)
    if everywhere:
        yield from fog_everywhere(everywhere, scene)
    if world.is_sky(scene):
        if world.is_baked(scene):
            yield Finding("world-baked")
            if world.smears_disc(scene):
                yield Finding("sky-disc")
        if world.changes(scene) and not everywhere:
            yield Finding("world-changes")
        if scene.world and world.depends_on_rays(scene) and not world.is_split(scene):
            yield Finding("world-depends-on-rays")
        if world.lights(scene) == "nothing" and (world.shines(scene) or world.is_baked(scene)):
            yield Finding("world-lights-nothing")
    elif own.background_strength == 0.0 and world.shines(scene):
        yield Finding("world-not-exported")


def fog_everywhere(found, scene):
    if world.changes(scene):
        yield Finding("world-changes")
    if fog.is_clipped_of(found, scene.camera):
        yield Finding("fog-clipped", "the world")
    boxes = (thing for thing in scene.objects if thing.sunfleck_settings.is_fog and not thing.hide_render)
    if any(fog.is_otherwise(found, fog.numbers(thing)) for thing in boxes):
        yield Finding("fog-overlaps", "the world")


def has_fog(scene):
    return any(thing.type == "VOLUME" or thing.sunfleck_settings.is_fog for thing in rendered(scene))


LAYER_PARTS = ("use_solid", "use_sky", "use_strand", "use_volumes")
WORLD_RAYS = ("camera", "diffuse", "glossy", "transmission", "scatter")


def is_box(scene):
    """Whether the shutter's curve is a box, only open or closed."""
    curve = scene.render.motion_blur_shutter_curve
    curve.initialize()
    values = [curve.evaluate(curve.curves[0], 0.05 + 0.1 * step) for step in range(10)]
    return min(values) > 0.99 and of_cycles(scene, "rolling_shutter_type", "NONE") == "NONE"


def of_cameras(scene):
    bound = [marker.camera for marker in scene.timeline_markers if marker.camera]
    for eye in dict.fromkeys([scene.camera, *bound]):
        if eye and eye.type != "CAMERA":
            yield Finding("camera-other", f"`{eye.name}`")
        elif eye and eye.data.type not in {"PERSP", "ORTHO"}:
            yield Finding("camera-panoramic", f"`{eye.name}`")
    lenses = {
        (eye.data.type, eye.data.shift_x, eye.data.shift_y, eye.data.clip_start, eye.data.clip_end)
        for eye in bound
        if eye.type == "CAMERA"
    }
    if len(lenses) > 1:
        yield Finding("camera-cuts", more=", ".join(sorted({f"`{eye.name}`" for eye in bound})))


RAYS = ("visible_diffuse", "visible_glossy", "visible_transmission", "visible_volume_scatter")
HONOURED = {"visible_camera", "visible_shadow", "is_holdout"}


def of_object(thing, scene):
    name = f"`{thing.name}`"
    if thing.type == "LIGHT":
        yield from of_light(name, thing, scene)
        return
    if thing.type == "CAMERA":
        if any(curve.data_path in {"shift_x", "shift_y", "clip_start", "clip_end"} for curve in curves_of(thing.data)):
            yield Finding("camera-values", name)
        dof, is_flat = thing.data.dof, thing.data.type == "ORTHO"
        is_turned = dof.aperture_ratio != 1.0 or (dof.aperture_blades >= 3 and dof.aperture_rotation != 0.0)
        if dof.use_dof and (is_flat or is_turned):
            yield Finding("camera-aperture", name)
        return
    if thing.type == "VOLUME" or thing.sunfleck_settings.is_fog:
        if thing.type == "VOLUME" and (reason := volumes.check(thing)):
            yield Finding("volume", name, reason)
        said = {
            "fog-not-a-cube": thing.type == "MESH" and not is_fogs_cube(thing),
            "fog-material": thing.type != "VOLUME" and fog.is_lost(thing),
            "fog-clipped": fog.is_clipped(thing, scene.camera),
            "fog-touches": fog.touches(thing, scene.objects),
            "fog-overlaps": fog.overlaps(thing, scene.objects),
            "ray-visibility": not all(getattr(thing, rays) for rays in (*RAYS, "visible_camera", "visible_shadow")),
        }
        yield from (Finding(id, name) for id, is_so in said.items() if is_so)
        return
    own = scene.sunfleck_settings
    bounces = own.all_bounces or own.bounces > 0
    said = {
        "grease-pencil": thing.type in {"GPENCIL", "GREASEPENCIL"},
        "point-cloud": thing.type == "POINTCLOUD",
        "hair": thing.type == "CURVES" or any(shows_hair(system.settings) for system in thing.particle_systems),
        "shadow-catcher": thing.is_shadow_catcher,
        "shadow-in-bounces": bounces and not thing.visible_shadow,
        "visibility-changes": any(curve.data_path in HONOURED for curve in curves_of(thing)),
        "ray-visibility": not all(getattr(thing, rays) for rays in RAYS),
        "light-linking": is_linked(thing),
        "adaptive-subdivision": any(getattr(modifier, "use_adaptive_subdivision", False) for modifier in thing.modifiers if modifier.show_render),
    }
    if thing.type not in {"EMPTY", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}:
        yield from (Finding(id, name) for id, is_so in said.items() if is_so)


def is_fogs_cube(thing):
    """Whether a mesh coincides with the cube from -1 to 1, along axes in which it is not flat."""
    sides = [(min(axis), max(axis)) for axis in zip(*thing.bound_box)]
    return all(high == low or (abs(low + 1.0) < 1e-5 and abs(high - 1.0) < 1e-5) for low, high in sides)


def shows_hair(settings):
    return settings.type == "HAIR" and settings.render_type == "PATH"


def is_linked(thing):
    linking = getattr(thing, "light_linking", None)
    return bool(linking and (linking.receiver_collection or linking.blocker_collection))


def of_light(name, thing, scene):
    light, own = thing.data, scene.sunfleck_settings
    said = {
        "light-power": light.energy < 0.0,
        "light-spread": light.type == "AREA" and light.spread < lights.NARROWEST_SPREAD,
        "light-square": light.type == "SPOT" and light.use_square,
        "light-uneven": light.type in {"AREA", "SPOT"} and is_uneven(thing.matrix_world, light.type == "SPOT"),
        "light-nodes": lights.of_nodes(light) is None,
        "light-shadowless": not light.use_shadow,
        "light-near": light.type in {"POINT", "SPOT"} and nearness.is_near_to_any(thing, scene.objects),
        "light-rays": not all(getattr(thing, rays) for rays in RAYS),
        "light-bounces": of_cycles(light, "max_bounces", 1024) < (1024 if own.all_bounces else own.bounces),
        "light-linking": is_linked(thing),
        "light-portal": is_a_portal(light),
    }
    yield from (Finding(id, name) for id, is_so in said.items() if is_so)


def is_uneven(place, is_round):
    """Whether a light's axes are not orthogonal or, for a round one, differ in length."""
    turned = place.to_3x3()
    lengths = [axis.length for axis in turned.col]
    straight = all(abs(turned.col[a].dot(turned.col[b])) <= 1e-4 * lengths[a] * lengths[b] for a, b in ((0, 1), (0, 2), (1, 2)))
    return not straight or (is_round and max(lengths) - min(lengths) > 1e-3 * max(lengths))


def of_material(material, own):
    name = f"the material `{material.name}`"
    output = principled.output_of(material.node_tree) if material.node_tree else None
    if output is None:
        return
    if links.link_to(output.inputs["Volume"]):
        yield Finding(
            "volume-beside-surface" if links.link_to(output.inputs["Surface"]) else "volume-material", name
        )
    if not (own.all_bounces or own.bounces) and any(map(is_mirror, dependence.nodes_of(material))):
        yield Finding("mirror-bounces", name)
    if dependence.is_transparent(material) and not material.use_transparent_shadow:
        yield Finding("material-shadows", name)
    if links.link_to(output.inputs["Displacement"]) and material.displacement_method != "BUMP":
        yield Finding("displacement", name)


def is_mirror(node):
    """Whether it is perfectly smooth metal."""
    roughness = node.inputs.get("Roughness")
    is_metal = node.type in {"BSDF_GLOSSY", "BSDF_ANISOTROPIC", "BSDF_METALLIC"} or (
        node.type == "BSDF_PRINCIPLED" and (node.inputs["Metallic"].is_linked or node.inputs["Metallic"].default_value > 0.0))
    return is_metal and not roughness.is_linked and roughness.default_value == 0.0


def is_hidden_at_times(thing):
    return any(curve.data_path == "hide_render" for curve in curves_of(thing))
