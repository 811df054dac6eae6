"""Animated parameters of lights, lenses, fog and the scene, frame by frame.

In go evaluated objects, out come values by owner. Invariant: plain values are those of the first frame;
animated ones are translations of nodes `ctl_...` (docs/scene-format.md, "Values that change").
"""

from types import SimpleNamespace

import numpy

from .. import extras, film, fog
from ..stored import by_hand
from . import cameras, lights, thinning
from .moments import steps_of
from .stays import Stays
from .walk import STAND_IN

# Tolerance relative to a value, above the 6e-8 of single precision.
TOLERANCE = 1e-6


class View:
    """Camera that renders at a moment: markers switch between cameras, even hidden ones."""

    def __init__(self, time, eye, evaluated, scene):
        self.time, self.eye = time, eye
        self.matrix = numpy.array(evaluated.matrix_world, float)
        self.said = lens(evaluated, scene)
        self.fields = camera(evaluated, scene)


class Values:
    """Values with their times."""

    def __init__(self, scene, shutter):
        # By the engine that the scene has before the walk sets its own.
        self.scene, self.shutter, self.exposure = scene, shutter, film.exposure(scene)
        self.lights, self.cameras = {}, {}
        # Custom properties of lights and fog at their first appearance.
        self.said = {}
        # Rendering camera at each moment: see `View`; and that of the frame.
        self.views, self.eye = [], scene.camera
        # Its placement at the frame, if it has one.
        self.held = None
        # Names of fogs whose own material counts in some frames alone.
        self.otherwise = set()
        # Fog everywhere, as it is first; and what is found to change and has no track.
        self.fog, self.stays = None, Stays(scene)
        # By owner (an object's key, or "scene") and field: frames and values.
        self.tracks = {}

    def see_scene(self, graph, frame, offset):
        # Markers switch cameras between frames, and not within a shutter.
        self.eye = eye = self.scene.camera if offset == 0.0 else self.eye
        is_there = eye is not None and eye.type == "CAMERA" and STAND_IN not in eye.data
        is_there = is_there and numpy.isfinite(eye.evaluated_get(graph).matrix_world).all()
        if offset == 0.0:
            self.held = None
        if is_there and self.shutter.is_step(offset, steps := steps_of(eye)):
            view = View(frame + offset, eye, eye.evaluated_get(graph), self.scene)
            if offset == 0.0:
                self.held = view.matrix
            elif self.shutter.holds(offset, steps):
                view.matrix = self.held
            self.views += [] if view.matrix is None else [view]
        if offset == 0.0:
            if eye is not None and eye.type == "CAMERA":
                self.stays.of_view(eye, eye.evaluated_get(graph), self.scene)
            self.stays.of_scene(graph)
            self.see_fog(frame, graph.scene_eval)

    def see_fog(self, frame, scene):
        """Records fog everywhere, which is there without density where the panel has none."""
        own = scene.sunfleck_settings
        if own.use_fog:
            self.fog = self.fog or extras.fog_everywhere(scene)
            self.see("scene", frame, of_fog("sunfleck_fog", {**fog.of_settings(own), "scale_height": own.scale_height}))
        else:
            self.see("scene", frame, {"sunfleck_fog.density": 0.0})

    def watch(self, key, instance, frame, offset):
        """Records an object without a surface, as the graph shows it; zooms within the shutter too."""
        # In a graph that renders again, Blender gives an instance's object the scale that it has by itself.
        thing, scale = instance.object, instance.matrix_world.to_scale()
        own = thing.sunfleck_settings
        if offset == 0.0:
            self.stays.of_object(key, thing, self.scene, self.exposure, scale)
        frame += offset
        if (own.is_fog or thing.type == "LIGHT") and key not in self.said:
            self.said[key] = extras.of_object(thing, self.scene, exposure=self.exposure, scale=scale)
        if own.is_fog:
            self.otherwise |= {thing.name} if fog.is_lost(thing) else set()
            found = fog.numbers(thing)
            if own.thins_out:
                found["scale_height"] = own.scale_height
            if own.use_mist:
                found |= fog.changing_mist(own)
            self.see(key, frame, of_fog("sunfleck_fog_volume", found))
        if thing.type == "LIGHT":
            self.lights.setdefault(key, SimpleNamespace(punctual=lights.punctual(thing.data, self.exposure)))
            self.see(key, frame, light(thing, self.exposure, scale))
        if thing.type == "CAMERA":
            self.cameras.setdefault(key, lens(thing, self.scene))
            self.see(key, frame, camera(thing, self.scene))

    def see(self, owner, frame, values):
        for field, value in values.items():
            self.tracks.setdefault((owner, field), []).append((frame, value))

    def changing(self):
        """Owner, field, frames and values (frames, 1 or 3) of animated parameters."""
        for (owner, field), found in self.tracks.items():
            if owner == "scene" and self.fog is None:
                continue
            # Open shutters are visited from their ends inwards, and may overlap.
            track = sorted(dict(found).items())
            if any(value != track[0][1] for _, value in track):
                frames = numpy.array([frame for frame, _ in track], float)
                # Numbers of a fog's panel are even, and its own material's are of three channels.
                width = max(numpy.size(value) for _, value in track)
                yield owner, field, frames, numpy.array([numpy.broadcast_to(value, width) for _, value in track], float)

    def write(self, assembly):
        """Writes the nodes of animated values."""
        document = assembly.document
        for owner, field, frames, values in self.changing():
            name = owner if owner == "scene" else assembly.node_name(owner)
            if name is None:
                continue
            channel = "translation" if values.shape[1] == 3 else "translation.x"
            said = {"target": f"{name}.{field}", "channel": channel}
            node = document.add("nodes", {"name": f"ctl_{name}.{field}", "extras": {"sunfleck_ctl": said}})
            places = values if values.shape[1] == 3 else numpy.pad(values, ((0, 0), (0, 2)))
            if assembly.shutter.length and field.startswith("sunfleck_light."):
                # Within the shutter, Cycles keeps lights as at its middle.
                assembly.uncentred |= set() if assembly.shutter.is_centred else {name}
                document.node_channel(node, "translation", assembly.clock.seconds(frames + assembly.shutter.switch), places, "STEP")
                continue
            tolerance = numpy.array([TOLERANCE * max(1e-12, float(numpy.abs(values).max()))])
            stays = thinning.straight(frames[None], places[None], numpy.array([len(frames)]), tolerance)[0]
            document.node_channel(node, "translation", assembly.clock.seconds(frames[stays]), places[stays])


def lens(thing, scene):
    """glTF's camera parameters, with the custom properties."""
    own = {**by_hand(thing.data), **extras.of_camera(thing.data, scene, thing)}
    return SimpleNamespace(camera=cameras.camera(thing.data, scene), extras=own)


def of_fog(owner, numbers):
    return {f"{owner}.{name}": tuple(value) if isinstance(value, list) else value for name, value in numbers.items()}


def light(thing, exposure, scale):
    data, said = thing.data, extras.light(thing, exposure, scale)
    field = "strength_w_m2" if data.type == "SUN" else "power_w"
    found = {f"sunfleck_light.{field}": tuple(said[field] * channel for channel in lights.color(data))}
    for number in ("angle", "radius", "picture_rotation"):
        if number in said:
            found[f"sunfleck_light.{number}"] = said[number]
    for part in ("real", "imaginary") if "fractal" in said else ():
        found[f"sunfleck_light.fractal_{part}"] = said["fractal"][part]
    if data.type == "SPOT":
        found["sunfleck_light.outer_angle"] = 0.5 * data.spot_size
        found["sunfleck_light.blend"] = data.spot_blend
    if data.type == "AREA":
        found["sunfleck_light.width"], found["sunfleck_light.height"] = lights.written_size(data)
        found["sunfleck_light.spread"] = lights.spread(data)
    return found


def camera(thing, scene):
    data, found = thing.data, {}
    if data.type == "PERSP":
        if data.dof.use_dof:
            found["sunfleck_camera.fstop"] = extras.f_stop(data)
            found["sunfleck_camera.focus_distance"] = extras.focus_distance(data, scene, thing)
        found["sunfleck_camera.yfov"] = cameras.field_of_view(data, scene)
    if data.type == "ORTHO":
        found["sunfleck_camera.height"] = 2.0 * cameras.camera(data, scene)["orthographic"]["ymag"]
    return found
