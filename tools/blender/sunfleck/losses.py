"""Features of a .blend that are not honoured, or only approximated (docs/blender-scenes.md).

Invariant: each loss has an id with a permanent meaning. An error prevents the export, a warning is a loss,
and `INFO` reports a replacement.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

ERROR, WARNING, INFO = "ERROR", "WARNING", "INFO"

LOSSES = {
    # The scene.
    "no-camera": (WARNING, "the scene has no active camera: sunfleck takes the first, or makes one up"),
    "unit-scale": (INFO, "the unit scale is not exported: one Blender unit is one metre"),
    "world-not-exported": (WARNING, "the world is not exported: tick World as sky in the panel, or give a "
                                    "background and a sun for its light"),
    "world-baked": (INFO, "the world's nodes are baked to a picture of 1024 x 512 texels"),
    "sky-disc": (WARNING, "the disc of a Sky Texture is a sun of its own only if there is one such disc, looked up "
                          "as usual, whose sky lights something: else it is smeared over texels"),
    "world-changes": (WARNING, "the world changes, and a file has it as it is now: the render engine has it in each "
                               "frame"),
    "world-lights-nothing": (WARNING, "the sky is seen and lights nothing: choose in the panel what it lights"),
    "world-rays": (WARNING, "the sky is seen and lights, whatever the world's ray visibility says"),
    "world-depends-on-rays": (WARNING, "the world's nodes tell rays apart, or look at the camera: it is and lights as "
                                       "a camera sees it that looks all around"),
    "world-volume": (WARNING, "the world's volume is more than numbers, or Fog everywhere in the panel takes its place"),
    "border": (WARNING, "a render border is not in the file: Frame and Animation render that region alone"),
    "pixel-aspect": (WARNING, "pixels are square here: the picture has the shape that Blender's has on a "
                              "screen with pixels of its aspect"),
    "film-exposure-changes": (WARNING, "the film's exposure changes: it is exported as it is now"),
    "settings-change": (WARNING, "the setting changes, and a file has it as it is in one frame: the render engine has it in "
                                 "each"),
    "frame-step": (WARNING, "every frame is in the file: Animation renders those of the step alone"),
    "view-layers": (WARNING, "one view layer is exported, the others that render are not"),
    "stereo": (WARNING, "views of stereoscopy are not exported: there is one camera"),
    "compositor": (WARNING, "the compositor is not run"),
    "sequencer": (WARNING, "strips of the sequencer are not rendered"),
    "freestyle": (WARNING, "Freestyle's lines are not drawn"),
    "working-space": (INFO, "colours of the working space are converted to linear Rec. 709"),
    "view-transform": (INFO, "pictures for eyes have the view AgX with its looks, without gamma, curves and white "
                             "balance: Blender shows frames by its own view"),
    "color-overrides": (WARNING, "the view layer's own world, and its own material on volumes and fog, is not honoured"),
    "layer-passes": (WARNING, "the view layer asks for passes that are not rendered"),
    "layer-filters": (WARNING, "surfaces, hair, sky and blur that a view layer leaves out are rendered"),
    "camera-culling": (WARNING, "what Cycles would cull, far away or beside the picture, is there"),
    # Cameras.
    "not-finite": (WARNING, "a place or a vertex is no finite number: the object is left out"),
    "camera-other": (ERROR, "the camera that renders is another object: make a camera in its place"),
    "camera-panoramic": (ERROR, "the camera that renders is panoramic or custom: make it perspective or orthographic"),
    "camera-cuts": (WARNING, "markers switch between cameras whose kind, shift or clipping differs: those "
                             "of the first camera stay"),
    "camera-values": (WARNING, "shift and clipping of a camera do not change: they stay as in the first "
                               "frame"),
    "camera-aperture": (WARNING, "blades of an aperture are neither turned nor stretched, and in an orthographic camera all is in focus"),
    "shutter-shape": (WARNING, "the shutter opens and closes at once, and everywhere at the same time"),
    "shutter-changes": (WARNING, "how long the shutter is open does not change: it is exported as it is now"),
    "motion-blur-off": (WARNING, "what Blender leaves sharp is blurred with the rest: centre the shutter on the frame"),
    # Lights.
    "light-power": (ERROR, "a light's power is negative"),
    "light-spread": (WARNING, "the spread of an area light is at least 0.01 radians"),
    "light-square": (WARNING, "a square spot is round"),
    "light-uneven": (WARNING, "a spot under an uneven scale is round, and a sheared area light has right angles"),
    "light-nodes": (WARNING, "light nodes are more than an Emission of one colour and strength: the light's "
                             "own power and colour count alone"),
    "light-shadowless": (WARNING, "lights that cast no shadows cast them here"),
    "light-near": (WARNING, "something lies within a light's radius: within two radii it is lit otherwise in Cycles"),
    "light-rays": (WARNING, "lights light everything, whatever their ray visibility says"),
    "light-blur": (WARNING, "a light that moves while the shutter is open shines from all along its way, and one that "
                            "changes is as at the frame; Cycles' is as in the middle of the shutter"),
    "light-bounces": (WARNING, "a light's own number of bounces is not honoured: it bounces as often as the others"),
    "light-linking": (WARNING, "light and shadow linking is not honoured: lights light everything"),
    "light-portal": (INFO, "portals light nothing and are not exported"),
    # Things.
    "volume": (WARNING, "a volume is not rendered"),
    "volume-lost": (WARNING, "of a volume something is lost"),
    "volume-material": (WARNING, "a volume material without a surface is not rendered, nor an opaque box: "
                                 "tick Holds fog in its panel"),
    "volume-beside-surface": (WARNING, "of a material with a surface and a volume only the surface is "
                                       "rendered"),
    "shadow-catcher": (WARNING, "shadow catchers are rendered like other surfaces"),
    "shadow-in-bounces": (WARNING, "what casts no shadow casts one where light bounces, on what it would light "
                                   "there"),
    "visibility-changes": (WARNING, "visibility to camera and shadows and holdouts do not change: they are "
                                    "exported as they are now"),
    "ray-visibility": (WARNING, "visibility to single kinds of rays is not honoured, but of surfaces to the "
                                "camera's and to shadows'"),
    "hair": (WARNING, "hair is exported as tubes of 48 sides, or 12 of much hair, like Cycles' 3D Curves (its ribbons "
                      "shade one another more where light goes along their row), or as ribbons that face the camera "
                      "of the first frame where it lets light through"),
    "hair-attributes": (WARNING, "hair of particles has no attributes of what it grows on"),
    "point-cloud": (WARNING, "points are exported as spheres of 20 sides"),
    "point-splats": (WARNING, "points of other types than the plain one are exported as spheres"),
    "grease-pencil": (WARNING, "grease pencil is not rendered"),
    "displacement": (WARNING, "true displacement by materials is not rendered"),
    "shadow-terminator": (WARNING, "a smooth mesh of few faces is dark where they turn away from a light, and Cycles "
                                   "moves its shadows (Shading > Shadow Terminator: Geometry Offset): subdivide it"),
    "coincident-faces": (WARNING, "faces lie in one place, where Cycles' picture is dark and depends on which its rays "
                                  "happen to meet first: delete one, or move it by a millimetre"),
    "coincident-unknown": (INFO, "faces in one place are looked for in the first 400,000 triangles alone"),
    "custom-normals": (WARNING, "custom normals lean far from their faces, which say here on which side light falls; "
                                "in Cycles the normals do"),
    "adaptive-subdivision": (WARNING, "a mesh that Cycles would subdivide by its size in the picture is "
                                      "subdivided as often as its modifier says"),
    "fog-not-a-cube": (WARNING, "fog fills the cube from -1 to 1 of an object, and its mesh reaches "
                                "elsewhere"),
    "fog-material": (WARNING, "the fog's own volume material is more than numbers: those of its panel count"),
    "fog-clipped": (WARNING, "the camera is in fog, which begins at the camera here and at its clip start in "
                             "Cycles: make that smaller"),
    "fog-touches": (WARNING, "a side of the fog lies in a surface or another fog's side, and Cycles' picture depends on which of them its "
                             "rays happen to meet first: move one by a millimetre"),
    "fog-overlaps": (WARNING, "fogs of other anisotropies and colours overlap: each colour goes its own way here, and "
                              "all go as their mean does in Cycles"),
    "velocity-blur": (WARNING, "what is blurred by velocities moves from where it is at the frame, and not in "
                               "the middle of the shutter"),
    # Materials.
    "material-baked": (INFO, "the material is baked"),
    "material-not-honoured": (WARNING, "the material is not honoured"),
    "material-lost": (WARNING, "of the material something is lost"),
    "material-glows": (INFO, "what glows is seen, and lights other things only where light bounces"),
    "mirror-bounces": (WARNING, "without bounces a mirror shows what is lit about it, and in Cycles is black there"),
    "material-shadows": (WARNING, "what is transparent casts shadows that are so too"),
    "material-changes": (WARNING, "the material changes in a way that is not honoured"),
    "instance-colors": (WARNING, "colours that differ from instance to instance are rounded to a number of "
                              "them"),
    # Counts after export.
    "count-instances": (WARNING, "the file shows another number of instances than Blender"),
    "count-area": (WARNING, "what the file shows has another area than in Blender"),
    "count-bounds": (WARNING, "what the file shows reaches elsewhere than in Blender"),
    "count-lights": (WARNING, "the file has another number of lights than Blender"),
    "count-materials": (WARNING, "the file shows other materials than Blender"),
}


@dataclass(frozen=True)
class Finding:
    """Loss of one object, or of the scene if it has no name."""

    id: str
    of: str = ""
    more: str = ""

    @property
    def severity(self) -> str:
        return LOSSES[self.id][0]

    @property
    def message(self) -> str:
        sentence = LOSSES[self.id][1]
        told = f"{self.of}: {sentence}" if self.of else sentence
        return f"{told}: {self.more}" if self.more else told

    def __str__(self) -> str:
        return f"[{self.id}] {self.message}"


# Maximum number of names in a message.
MOST_NAMED = 3


def by_kind(findings: Iterable[Finding]) -> Iterator[Finding]:
    """One finding for each kind, with its first names and the number of others."""
    kinds: dict[str, list[Finding]] = {}
    for finding in findings:
        kinds.setdefault(finding.id, []).append(finding)
    for id, found in kinds.items():
        names = list(dict.fromkeys(finding.of for finding in found if finding.of))
        named = ", ".join(names[:MOST_NAMED])
        if len(names) > MOST_NAMED:
            named += f" and {len(names) - MOST_NAMED} more"
        yield Finding(id, named, found[0].more)


def ordered(findings: Iterable[Finding]) -> list[Finding]:
    """Unique findings, errors first."""
    order = (ERROR, WARNING, INFO)
    return sorted(dict.fromkeys(findings), key=lambda finding: order.index(finding.severity))
