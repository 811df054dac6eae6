"""Small scenes whose light of higher orders is hard to find, and changes that must not matter to it.

A scene is the text of a RON file. `write` puts it into a folder, with the pictures that it names.
"""

from pathlib import Path

import numpy as np

from sunfleck_tools.exr.write import write_colors

SKY = "Gradient(zenith_w_per_m2_sr: (0.2, 0.35, 0.8), horizon_w_per_m2_sr: (0.8, 0.85, 0.9), ground_w_per_m2_sr: (0.1, 0.08, 0.05))"

# A crown of 400 leaves above ground, in a box of fog, under a sun and a sky.
BASE = {
    "meshes": {
        "leaf": "Leaf(length_m: 0.1, width_m: 0.07, curl_deg: 25.0)",
        "ground": "Quad(size_m: 20.0)",
        "cube": "Cube(size_m: 1.0)",
    },
    "materials": {
        "gold": "(base_color: (0.5, 0.25, 0.02), transmission: (0.4, 0.2, 0.01))",
        "soil": "(base_color: 0.3)",
        "plaster": "(base_color: (0.75, 0.73, 0.68))",
        "bark": "(base_color: (0.14, 0.11, 0.09))",
    },
    "objects": {"ground": '(mesh: "ground", material: "soil")'},
    "leaves": {
        "crown": '(count: 400, seed: 3, meshes: ["leaf"], materials: ["gold"], min_m: (-1.5, 0.2, -1.5), max_m: (1.5, 2.0, 1.5))'
    },
    "cameras": {"main": "(position_m: (0.3, 1.1, 4.5), look_at_m: (0.0, 0.9, 0.0), fov_deg: 42.0)"},
    "lights": {"sun": "Sun(to_sun: (0.5, 1.0, -0.4), irradiance_w_per_m2: (12.0, 9.0, 5.5))"},
    "fog": {"haze": "(min_m: (-3.0, 0.0, -3.0), max_m: (3.0, 3.0, 3.0), density_per_m: 0.15, anisotropy: 0.5)"},
}


def scene(sky: str = SKY, /, **changed: dict[str, str] | None) -> str:
    """Text of the base scene with some of its maps replaced, or left out if None."""
    parts = {name: entries for name, entries in {**BASE, **changed}.items() if entries}
    maps = "".join(
        f"    {name}: {{ " + ", ".join(f'"{key}": {value}' for key, value in entries.items()) + " },\n"
        for name, entries in parts.items()
    )
    above = f"    sky: {sky},\n" if sky else ""
    return f"Scene(\n    version: 1,\n{maps}{above})\n"


def block(low: tuple[float, float, float], high: tuple[float, float, float], material: str = "plaster") -> str:
    """A box from corner to corner, metres."""
    middle, size = np.add(low, high) / 2, np.subtract(high, low)
    return f'(mesh: "cube", material: "{material}", translation_m: {tuple(middle.tolist())}, scale: {tuple(size.tolist())})'


def more(name: str, **entries: str) -> dict[str, dict[str, str]]:
    """Map of the base scene with additional entries."""
    return {name: {**BASE[name], **entries}}


def room(**changed: dict[str, str] | None) -> str:
    """A room of 4 x 3 x 3 m with a window to the right, fog in it and leaves before the window."""
    walls = {
        "floor": block((-2, -0.2, -1.5), (2, 0, 1.5)),
        "ceiling": block((-2, 3, -1.5), (2, 3.2, 1.5)),
        "back": block((-2, 0, -1.7), (2, 3, -1.5)),
        "front": block((-2, 0, 1.5), (2, 3, 1.7)),
        "left": block((-2.2, 0, -1.5), (-2, 3, 1.5)),
        "sill": block((2, 0, -1.5), (2.2, 1, 1.5)),
        "lintel": block((2, 2.4, -1.5), (2.2, 3, 1.5)),
        "jamb": block((2, 1, -1.5), (2.2, 2.4, -0.7)),
        "other jamb": block((2, 1, 0.7), (2.2, 2.4, 1.5)),
        "ground": '(mesh: "ground", material: "soil", translation_m: (0.0, -0.3, 0.0))',
    }
    ours = {
        "objects": walls,
        "leaves": {
            "branch": '(count: 60, seed: 5, meshes: ["leaf"], materials: ["gold"], min_m: (2.6, 1.0, -0.9), max_m: (3.6, 2.6, 0.9))'
        },
        "cameras": {"main": "(position_m: (-1.7, 1.5, 1.1), look_at_m: (1.2, 1.2, -0.6), fov_deg: 75.0)"},
        "lights": {"sun": "Sun(to_sun: (1.0, 0.7, 0.2), irradiance_w_per_m2: (12.0, 9.0, 5.5))"},
        "fog": {"haze": "(min_m: (-2.0, 0.0, -1.5), max_m: (2.0, 3.0, 1.5), density_per_m: 0.1, anisotropy: 0.4)"},
    }
    return scene(**{**ours, **changed})


def lamp_room(below_ceiling_m: float) -> str:
    """A closed room of 4 m with a lamp below its ceiling."""
    return scene(
        "",
        leaves=None,
        fog=None,
        objects={"room": block((-2, 0, -2), (2, 4, 2))},
        lights={"lamp": f"Point(position_m: (0.0, {4 - below_ceiling_m}, 0.0), intensity_w_per_sr: 1.0)"},
        cameras={"main": "(position_m: (0.3, 1.1, 1.7), look_at_m: (0.0, 1.5, 0.0), fov_deg: 80.0)"},
    )


def trunks() -> str:
    """A path between two rows of trunks, a low sun across it."""
    posts = {
        f"trunk {row}{side}": block((x - 0.2, 0, -2.5 * row), (x + 0.2, 6, 0.4 - 2.5 * row), "bark")
        for row in range(5)
        for side, x in enumerate((-1.6, 1.7))
    }
    return scene(
        objects={**BASE["objects"], **posts},
        leaves={
            "crown": '(count: 900, seed: 4, meshes: ["leaf"], materials: ["gold"], min_m: (-3.0, 2.5, -11.0), max_m: (3.0, 5.5, 1.0), scale: (1.5, 2.5))'
        },
        cameras={"main": "(position_m: (0.2, 1.5, 4.5), look_at_m: (0.0, 1.6, -4.0), fov_deg: 50.0)"},
        lights={"sun": "Sun(to_sun: (0.9, 0.6, -0.5), irradiance_w_per_m2: (12.0, 9.0, 5.5))"},
        fog={"haze": "(min_m: (-6.0, 0.0, -14.0), max_m: (6.0, 6.0, 5.0), density_per_m: 0.05, anisotropy: 0.6)"},
    )


def wall() -> str:
    """Red leaves next to a white wall, whose light colours it."""
    return scene(
        materials={**BASE["materials"], "red": "(base_color: (0.7, 0.06, 0.04), transmission: (0.1, 0.01, 0.01))"},
        objects={**BASE["objects"], "wall": block((-3, 0, -0.4), (3, 3, -0.2))},
        leaves={
            "ivy": '(count: 60, seed: 8, meshes: ["leaf"], materials: ["red"], min_m: (-1.4, 0.3, -0.14), max_m: (1.4, 1.9, -0.1), scale: 2.5, droop_deg: (60.0, 80.0))'
        },
        cameras={"main": "(position_m: (0.3, 1.1, 2.8), look_at_m: (0.0, 1.0, -0.2), fov_deg: 42.0)"},
        lights={"sun": "Sun(to_sun: (0.4, 0.8, 0.7), irradiance_w_per_m2: (9.0, 9.0, 9.0))"},
        fog=None,
    )


def mist(scale_height_m: float, *, boxed: bool = False) -> str:
    """Fog that falls off with height over ground of 200 m, with a camera among leaves."""
    bounds = "min_m: (-30.0, 0.0, -30.0), max_m: (30.0, 20.0, 30.0), " if boxed else ""
    depth = 0.3 / scale_height_m
    return scene(
        meshes={**BASE["meshes"], "ground": "Quad(size_m: 200.0)"},
        fog={"mist": f"({bounds}scale_height_m: {scale_height_m}, density_per_m: {depth:.3f}, anisotropy: 0.5)"},
    )


def dense(density_per_m: float) -> str:
    """Uniform fog in the box."""
    return scene(fog={"haze": BASE["fog"]["haze"].replace("0.15", f"{density_per_m}")})


def thick() -> str:
    """Fog of depth 6 that scatters ahead, towards the sun."""
    return scene(
        fog={"haze": "(min_m: (-3.0, 0.0, -3.0), max_m: (3.0, 3.0, 3.0), density_per_m: 1.0, anisotropy: 0.85)"},
        lights={"sun": "Sun(to_sun: (0.1, 0.5, -1.0), irradiance_w_per_m2: (12.0, 9.0, 5.5))"},
    )


def slits() -> str:
    """A hall of 6 x 3 x 4 m that three slits of 12 cm light, with thin fog in it."""
    edges = (-3.0, -1.6, -1.48, 0.0, 0.12, 1.5, 1.62, 3.0)
    piers = {f"pier {i}": block((edges[2 * i], 0, 2), (edges[2 * i + 1], 3, 2.3)) for i in range(4)}
    walls = {
        "floor": block((-3, -0.2, -2), (3, 0, 2.3)),
        "ceiling": block((-3, 3, -2), (3, 3.2, 2.3)),
        "back": block((-3, 0, -2.2), (3, 3, -2)),
        "left": block((-3.2, 0, -2.2), (-3, 3, 2.3)),
        "right": block((3, 0, -2.2), (3.2, 3, 2.3)),
        "ground": '(mesh: "ground", material: "soil", translation_m: (0.0, -0.3, 0.0))',
    }
    return scene(
        objects={**walls, **piers},
        leaves=None,
        cameras={"main": "(position_m: (-2.6, 1.6, 1.6), look_at_m: (1.5, 1.1, -1.4), fov_deg: 72.0)"},
        lights={"sun": "Sun(to_sun: (0.35, 0.6, 1.0), irradiance_w_per_m2: (12.0, 9.0, 5.5))"},
        fog={"haze": "(min_m: (-3.0, 0.0, -2.0), max_m: (3.0, 3.0, 2.0), density_per_m: 0.08, anisotropy: 0.5)"},
    )


def canyon() -> str:
    """A bent street between walls of 8 m in mist without bounds, a low sun along it."""
    return scene(
        meshes={**BASE["meshes"], "ground": "Quad(size_m: 120.0)"},
        objects={
            **BASE["objects"],
            "left": block((-4, 0, -14), (-2, 8, 6)),
            "right": block((2, 0, -9), (4, 7, 6)),
            "end": block((-2, 0, -16), (9, 6, -14)),
        },
        leaves={
            "ivy": '(count: 300, seed: 9, meshes: ["leaf"], materials: ["gold"], min_m: (1.6, 0.5, -8.0), max_m: (2.0, 5.0, 2.0), scale: 2.0)'
        },
        cameras={"main": "(position_m: (-0.8, 1.7, 5.5), look_at_m: (0.4, 2.6, -8.0), fov_deg: 55.0)"},
        lights={"sun": "Sun(to_sun: (0.55, 0.3, -0.8), irradiance_w_per_m2: (12.0, 7.0, 3.0))"},
        fog={"mist": "(scale_height_m: 3.0, density_per_m: 0.08, anisotropy: 0.6)"},
    )


def night() -> str:
    """Lamps beneath a canopy at night, in mist that lies on the ground."""
    lamps = {
        f"lamp {i}": f"Point(position_m: ({x}, {y}, {z}), intensity_w_per_sr: ({red}, {0.7 * red:.2f}, {0.4 * red:.2f}))"
        for i, (x, y, z, red) in enumerate([(-1.2, 1.6, -0.5, 3.0), (1.4, 2.1, -2.5, 5.0), (0.2, 0.6, 1.0, 1.0)])
    }
    return scene(
        "Constant(radiance_w_per_m2_sr: (0.002, 0.003, 0.006))",
        meshes={**BASE["meshes"], "ground": "Quad(size_m: 100.0)"},
        objects={**BASE["objects"], "trunk": block((-0.6, 0, -1.8), (-0.2, 3, -1.4), "bark")},
        leaves={
            "crown": '(count: 1500, seed: 6, meshes: ["leaf"], materials: ["gold"], min_m: (-3.0, 2.3, -4.0), max_m: (3.0, 3.6, 2.0), scale: (1.0, 2.0))'
        },
        lights=lamps,
        fog={"mist": "(scale_height_m: 0.6, density_per_m: 0.4, anisotropy: 0.7)"},
    )


def lanterns(*, glowing: bool = False) -> str:
    """Two lamps, or an emissive cube, beneath leaves in unbounded mist."""
    lamps = {
        "lamp": "Point(position_m: (-1.0, 1.5, -1.0), intensity_w_per_sr: (3.0, 2.0, 1.0))",
        "lower": "Point(position_m: (1.8, 0.7, 0.5), intensity_w_per_sr: (1.0, 0.8, 0.6))",
    }
    cube = '(mesh: "cube", material: "glow", translation_m: (0.8, 0.9, 0.6), scale: 0.25)'
    return scene(
        "Constant(radiance_w_per_m2_sr: (0.002, 0.003, 0.006))",
        meshes={**BASE["meshes"], "ground": "Quad(size_m: 80.0)"},
        materials={**BASE["materials"], "glow": "(base_color: 0.5, emission_w_per_m2_sr: (30.0, 20.0, 10.0))"},
        objects={**BASE["objects"], **({"cube": cube} if glowing else {})},
        lights=None if glowing else lamps,
        fog={"mist": "(scale_height_m: 1.2, density_per_m: 0.25, anisotropy: 0.7)"},
    )


def two_rooms() -> str:
    """A room lit through a door by the next one, which has a window."""
    walls = {
        "floor": block((-4, -0.2, -2), (4, 0, 2)),
        "ceiling": block((-4, 2.8, -2), (4, 3, 2)),
        "back": block((-4, 0, -2.2), (4, 2.8, -2)),
        "front": block((-4, 0, 2), (4, 2.8, 2.2)),
        "left": block((-4.2, 0, -2), (-4, 2.8, 2)),
        "wall": block((-0.1, 0, -2), (0.1, 2.8, -0.5)),
        "other wall": block((-0.1, 0, 0.5), (0.1, 2.8, 2)),
        "above the door": block((-0.1, 2.1, -0.5), (0.1, 2.8, 0.5)),
        "sill": block((4, 0, -2), (4.2, 1, 2)),
        "lintel": block((4, 2.3, -2), (4.2, 2.8, 2)),
        "jamb": block((4, 1, -2), (4.2, 2.3, -1)),
        "other jamb": block((4, 1, 1), (4.2, 2.3, 2)),
        "ground": '(mesh: "ground", material: "soil", translation_m: (0.0, -0.3, 0.0))',
    }
    return scene(
        objects=walls,
        leaves=None,
        cameras={"main": "(position_m: (-3.6, 1.5, 1.2), look_at_m: (1.0, 1.1, -0.4), fov_deg: 70.0)"},
        lights={"sun": "Sun(to_sun: (1.0, 0.6, 0.15), irradiance_w_per_m2: (12.0, 9.0, 5.5))"},
        fog={"haze": "(min_m: (-4.0, 0.0, -2.0), max_m: (4.0, 2.8, 2.0), density_per_m: 0.05, anisotropy: 0.4)"},
    )


def tunnel() -> str:
    """A tunnel of 15 m, open at its far end, with leaves before that."""
    walls = {
        "floor": block((-1.2, -0.2, -12), (1.2, 0, 3), "soil"),
        "roof": block((-1.2, 2.4, -12), (1.2, 2.6, 3)),
        "left": block((-1.4, -0.2, -12), (-1.2, 2.6, 3)),
        "right": block((1.2, -0.2, -12), (1.4, 2.6, 3)),
        "end": block((-1.4, -0.2, 3), (1.4, 2.6, 3.2)),
        "ground": '(mesh: "ground", material: "soil", translation_m: (0.0, -0.3, -20.0), scale: 2.0)',
    }
    return scene(
        objects=walls,
        leaves={
            "tree": '(count: 200, seed: 3, meshes: ["leaf"], materials: ["gold"], min_m: (-1.2, 0.3, -14.5), max_m: (1.2, 2.3, -12.3))'
        },
        cameras={"main": "(position_m: (0.3, 1.5, 2.0), look_at_m: (0.0, 1.2, -12.0), fov_deg: 60.0)"},
        lights={"sun": "Sun(to_sun: (0.3, 0.8, -1.0), irradiance_w_per_m2: (12.0, 10.0, 8.0))"},
        fog={"haze": "(min_m: (-1.2, 0.0, -12.0), max_m: (1.2, 2.4, 3.0), density_per_m: 0.08, anisotropy: 0.6)"},
    )


def spot() -> str:
    """A narrow spot through leaves in thick fog."""
    lamp = "position_m: (1.5, 3.4, -2.0), target_m: (-0.2, 0.6, 0.2), outer_deg: 20.0, blend: 0.0"
    return scene(
        "Constant(radiance_w_per_m2_sr: (0.004, 0.006, 0.012))",
        lights={"spot": f"Spot({lamp}, intensity_w_per_sr: (60.0, 50.0, 40.0))"},
        fog={"haze": "(min_m: (-3.0, 0.0, -3.0), max_m: (3.0, 3.0, 3.0), density_per_m: 0.7, anisotropy: 0.6)"},
    )


def dome() -> str:
    """Leaves that close over snow, with a gap towards the sky."""
    return scene(
        materials={**BASE["materials"], "snow": "(base_color: (0.92, 0.93, 0.95))"},
        objects={"ground": '(mesh: "ground", material: "snow")'},
        leaves={
            name: f'(count: {count}, seed: {seed}, meshes: ["leaf"], materials: ["gold"], min_m: {low}, max_m: {high}, scale: 2.0)'
            for name, count, seed, low, high in [
                ("roof", 1500, 1, "(-2.5, 2.2, -2.5)", "(2.5, 2.8, 1.2)"),
                ("left", 700, 2, "(-2.8, 0.1, -2.5)", "(-2.2, 2.6, 2.5)"),
                ("right", 700, 3, "(2.2, 0.1, -2.5)", "(2.8, 2.6, 2.5)"),
                ("back", 700, 4, "(-2.5, 0.1, -2.8)", "(2.5, 2.6, -2.2)"),
            ]
        },
        cameras={"main": "(position_m: (0.4, 1.1, 2.4), look_at_m: (-0.2, 0.9, -2.0), fov_deg: 70.0)"},
        fog={"haze": "(min_m: (-3.0, 0.0, -3.0), max_m: (3.0, 3.0, 3.0), density_per_m: 0.05, anisotropy: 0.4)"},
    )


SUN_SKY = "sun_sky.exr"


def sun_sky() -> str:
    """A sky image with a sun of 2 degrees in it."""
    return scene(f'Image(image: "{SUN_SKY}")', lights=None)


def write_sky(path: Path) -> None:
    """A sky of 512 x 256 texels, blue above, with a sun of 2 degrees at 35 degrees of height."""
    rows, columns = np.mgrid[0:256, 0:512] + 0.5
    height, turn = np.pi / 2 - np.pi * rows / 256, 2 * np.pi * columns / 512 - np.pi
    texels = np.where(height[..., None] > 0, (0.3, 0.45, 0.8), (0.1, 0.08, 0.05))
    sun = np.radians(35), np.radians(60)
    cosine = np.sin(height) * np.sin(sun[0]) + np.cos(height) * np.cos(sun[0]) * np.cos(turn - sun[1])
    texels = texels + np.where(cosine[..., None] > np.cos(np.radians(1.0)), (9e3, 7e3, 5e3), 0.0)
    write_colors(path, texels)


def moved(turn: str = "", at: str = "(0.0, 0.0, 0.0)", scale: float = 1.0) -> str:
    """Base scene rotated, moved or scaled as a whole, under a uniform sky, which rotation does not change."""
    frame = f"translation_m: {at}{turn and f', rotation_deg: {turn}'}, scale: {scale}"
    return scene(
        "Constant(radiance_w_per_m2_sr: (0.5, 0.6, 0.8))",
        objects={"all": f"({frame})", "ground": '(mesh: "ground", material: "soil", parent: "all")'},
        leaves={"crown": BASE["leaves"]["crown"].replace("(count", '(parent: "all", count')},
        cameras={"main": BASE["cameras"]["main"].replace("(position", '(parent: "all", position')},
        lights={"sun": BASE["lights"]["sun"].replace("Sun(", 'Sun(parent: "all", ')},
        fog={"haze": BASE["fog"]["haze"].replace("(min", '(parent: "all", min').replace("0.15", f"{0.15 / scale}")},
    )


SCENES = {
    "base": scene,
    "low sun": lambda: scene(lights={"sun": "Sun(to_sun: (0.5, 0.15, -1.0), irradiance_w_per_m2: (12.0, 7.0, 3.0))"}),
    "no fog": lambda: scene(fog=None),
    "large leaves": lambda: scene(meshes={**BASE["meshes"], "leaf": "Leaf(length_m: 0.3, width_m: 0.2, curl_deg: 25.0)"}),
    "room": room,
    "trunks": trunks,
    "wall": wall,
    "thick": thick,
    "slits": slits,
    "canyon": canyon,
    "night": night,
    "lanterns": lanterns,
    "glowing lantern": lambda: lanterns(glowing=True),
    "two rooms": two_rooms,
    "tunnel": tunnel,
    "spot": spot,
    "dome": dome,
    "sun in the sky": sun_sky,
    **{f"lamp {mm} mm": lambda mm=mm: lamp_room(mm / 1000) for mm in (100, 10, 1)},
    **{f"dense {density}": lambda density=density: dense(density) for density in (0.5, 2, 5, 30)},
    **{f"mist {height}": lambda height=height: mist(height) for height in (0.05, 0.5, 1, 2, 8)},
    **{f"mist {height} boxed": lambda height=height: mist(height, boxed=True) for height in (0.5, 2)},
}


# What must not change the base scene's picture, each with the scene that it is to be like.
CHANGES = {
    **{
        f"stray {far_m} m": ("base", lambda far_m=far_m: scene(**more("objects", far=f'(mesh: "leaf", material: "gold", translation_m: (0.0, 1.0, {far_m}.0))')))
        for far_m in (100, 1000, 10000, 100000)
    },
    "stray fog": ("base", lambda: scene(**more("fog", far="(min_m: (9999.0, 0.0, 0.0), max_m: (10000.0, 1.0, 1.0), density_per_m: 0.1)"))),
    "turned": ("upright", lambda: moved("(0.0, 77.0, 0.0)")),
    "tilted 30": ("upright", lambda: moved("(0.0, 0.0, 30.0)")),
    "tilted 77": ("upright", lambda: moved("(77.0, 20.0, 0.0)")),
    "scaled": ("upright", lambda: moved(scale=10.0)),
    "far away": ("upright", lambda: moved(at="(1e6, 0.0, 1e6)")),
}
SCENES["upright"] = moved


def write(name: str, folder: Path) -> Path:
    """Writes the named scene as a file in a folder."""
    path = folder / f"{name.replace(' ', '_')}.ron"
    path.write_text(SCENES[name]() if name in SCENES else CHANGES[name][1]())
    if SUN_SKY in path.read_text():
        write_sky(folder / SUN_SKY)
    return path
