"""Settings that change and that no track of a file changes: what is found of them frame by frame.

In go the dictionaries that a file would have at each frame, out come findings. Invariant: what differs between
two frames has a track or a finding.
"""

import bpy

from .. import extras, fog, keys, world
from ..losses import Finding

# Fields with tracks (`values`), where a file has them at all frames.
CARRIED = {
    "sunfleck.camera",
    *(f"sunfleck_fog.{field}" for field in ("density", "albedo", "anisotropy", "scale_height")),
    *(f"sunfleck_fog_volume.{field}" for field in ("density", "albedo", "anisotropy", "scale_height", "emission")),
    *(f"sunfleck_fog_volume.mist.{field}" for field in ("cover", "wind", "evolution_turns")),
    *(f"sunfleck_light.{field}" for field in (
        "strength_w_m2", "power_w", "color", "angle", "radius", "size", "spread", "picture_rotation", "fractal.real",
        "fractal.imaginary")),
    "sunfleck_camera.fstop", "sunfleck_camera.focus_distance",
}
# Losses with ids of their own.
IDS = {
    "sunfleck.shutter": "shutter-changes", "sunfleck.shutter_offset": "shutter-changes",
    "camera.znear": "camera-values", "camera.zfar": "camera-values", "sunfleck_camera.shift": "camera-values",
}
# What `camera-cuts` is about, where markers switch between cameras.
OF_CUTS = {"camera.type", "camera.znear", "camera.zfar", "sunfleck_camera.shift"}


SCENE, VIEW = "the scene", "the view"


class Stays:
    """What is the same in every frame of a file."""

    def __init__(self, scene):
        # During a walk, the scene has the walk's own engine.
        self.is_left_to_blender = world.is_left_to_blender(scene)
        self.first, self.lost, self.eyes = {}, set(), []
        # Whose fog is everywhere: a file has the panel's, if any frame does.
        self.fogs = set()
        # Leaf ids are of surfaces, which are many: of those whose panel is keyed or driven.
        self.keyed = [
            thing for thing in bpy.data.objects
            if any(curve.data_path.startswith("sunfleck_settings.") for curve in keys.curves_of(thing))
        ]

    def see(self, name, said, part=None):
        """Compares a dictionary with the first of that name and part."""
        found = dict(flat(said))
        first = self.first.setdefault((name, part), found)
        for field in first.keys() | found.keys() if found != first else ():
            is_carried = field in CARRIED and field in first and field in found
            if first.get(field) != found.get(field) and not is_carried:
                self.lost.add((name, field))

    def of_scene(self, graph):
        """The panels' settings; `check` knows whether a world is keyed."""
        scene, own = graph.scene_eval, graph.scene_eval.sunfleck_settings
        is_sky = self.is_left_to_blender or own.use_world
        lights = None if self.is_left_to_blender else own.sky_lights
        sky = {"lights": lights, "world": is_sky, "visible_to_camera": not scene.render.film_transparent}
        if not is_sky:
            sky |= {"color": tuple(own.background_color), "strength": own.background_strength}
        self.see(SCENE, {"sunfleck": extras.settings(scene)})
        self.see("the sky", {"sunfleck_env": sky})
        if own.use_fog:
            self.see("fog everywhere", {"sunfleck_fog": extras.fog_everywhere(scene)})
        self.fogs.add("panel" if own.use_fog else "world" if fog.of_world(scene) else "none")
        for thing in self.keyed:
            own = thing.evaluated_get(graph).sunfleck_settings
            self.see(f"`{thing.name}`", {"panel.leaf_id": own.leaf_id if own.use_leaf_id else None}, "leaf")

    def of_object(self, key, thing, scene, exposure, scale):
        said = of_camera(thing, scene) if thing.type == "CAMERA" else extras.of_object(thing, scene, exposure=exposure, scale=scale)
        said.pop("leaf_id", None)
        self.see(f"`{thing.name}`", said, key)

    def of_view(self, eye, evaluated, scene):
        """The camera that renders, by markers one after the other."""
        self.eyes.append(eye)
        self.see(VIEW, of_camera(evaluated, scene))

    def findings(self):
        if self.fogs >= {"panel", "world"}:
            yield Finding("settings-change", "`volume` of the world")
        are_cuts = len(set(self.eyes)) > 1
        for name, field in sorted(self.lost):
            if name == VIEW:
                if are_cuts and field in OF_CUTS:
                    continue
                name = "the camera of markers" if are_cuts else f"`{self.eyes[0].name}`"
            if field in IDS:
                yield Finding(IDS[field], "" if name == SCENE else name)
            else:
                yield Finding("settings-change", f"`{field.split('.', 1)[1]}` of {name}")


def of_camera(eye, scene):
    """A camera's kind, clipping and custom properties; its sensor counts where its aperture does."""
    said, lens = extras.of_camera(eye.data, scene, eye), eye.data
    if "fstop" not in said["sunfleck_camera"]:
        del said["sunfleck_camera"]["sensor_width_mm"]
    return {**said, "camera": {"type": lens.type, "znear": lens.clip_start, "zfar": lens.clip_end}}


def flat(said, before=""):
    """Fields of nested dictionaries, with dots."""
    for name, value in said.items():
        if isinstance(value, dict):
            yield from flat(value, f"{before}{name}.")
        else:
            yield f"{before}{name}", value
