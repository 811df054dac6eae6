"""RenderSettings of a stage to those of the file (https://openusd.org/release/user_guides/schemas/usdRender).

The stage's `renderSettingsPrimPath` selects one of several, else the first counts. Invariant: every
request is honoured or reported.
"""

import math

from pxr import Usd, UsdGeom, UsdRender

from .losses import Losses
from .options import ImportOptions
from .source import Source

KIND = "usd-render-settings"
LARGEST = 65536
"""Maximum pixels along a side."""
NEARLY = 0.01
"""Tolerance of equal ratios."""
READ = {"camera", "resolution", "pixelAspectRatio", "includedPurposes", "disableMotionBlur", "instantaneousShutter",
        "aspectRatioConformPolicy", "products", "materialBindingPurposes", "renderingColorSpace", "dataWindowNDC"}  # fmt: skip


Lenses = dict[str, tuple[str, float | None]]
"""For each camera, by its path: its node's name and its exposure in stops."""


def take_render_settings(
    sunfleck: dict, source: Source, options: ImportOptions, lenses: Lenses, lost: Losses
) -> None:
    """Adds settings that the renderer's own properties in the stage lack."""
    asked = read_render_settings(source, options, lost)
    camera = str(asked.pop("camera", ""))
    if camera in lenses:
        sunfleck.setdefault("camera", lenses[camera][0])
    for name, value in asked.items():
        sunfleck.setdefault(name, value)


def take_exposure(sunfleck: dict, lenses: Lenses) -> None:
    """Adds the exposure of the chosen camera."""
    taken = next((each for each in lenses.values() if each[0] == sunfleck.get("camera")), None)
    taken = taken or next(iter(lenses.values()), None)
    if taken is not None and taken[1] is not None:
        sunfleck.setdefault("exposure", taken[1])


def read_render_settings(source: Source, options: ImportOptions, lost: Losses) -> dict:
    """Fields of the scene's `sunfleck`; `camera` is a path."""
    prim = _settings(source.stage)
    if prim is None:
        return {}
    product = _first_product(prim, lost)
    found: dict = {}
    _read_camera(prim, product, found, lost)
    size = _value(product, prim, "resolution", source)
    if size is not None:
        if all(1 <= each <= LARGEST for each in size):
            found["resolution"] = [int(each) for each in size]
        else:
            lost.add(KIND, prim, f"its resolution {tuple(size)} is none that can be, and is passed over")
    if any(_authored(prim, name, source) for name in ("disableMotionBlur", "instantaneousShutter")):
        found["shutter"] = 0.0
    pixel = _value(product, prim, "pixelAspectRatio", source)
    if pixel is not None and abs(pixel - 1) > 1e-6:
        lost.add(KIND, prim, f"pixels {pixel:g} times as wide as high are square here: its pixelAspectRatio is not carried")
    window = _value(product, prim, "dataWindowNDC", source)
    if window is not None and tuple(window) != (0, 0, 1, 1):
        lost.add(KIND, prim, "its dataWindowNDC is not carried: render a part by --crop")
    purposes = _authored(prim, "includedPurposes", source)
    if purposes is not None and {str(each) for each in purposes} - {"default"} != set(options.purposes):
        asked = ",".join(str(each) for each in purposes)
        lost.add(KIND, prim, f"its includedPurposes {asked} are not those that are read: ask by --purpose")
    space = _authored(prim, "renderingColorSpace", source)
    if space and str(space) not in ("lin_rec709", "lin_rec709_scene", "raw"):
        lost.add(KIND, prim, f"its renderingColorSpace {space} is not carried: light is in linear Rec. 709")
    _say_the_rest(prim, lost)
    if "resolution" in found:
        _say_shape(source, prim, found, lost)
    return found


def _settings(stage: Usd.Stage) -> Usd.Prim | None:
    named = UsdRender.Settings.GetStageRenderSettings(stage)
    if named:
        return named.GetPrim()
    return next((prim for prim in stage.Traverse() if prim.IsA(UsdRender.Settings)), None)


def _first_product(prim: Usd.Prim, lost: Losses) -> Usd.Prim | None:
    """First render product, which may have a camera and a resolution of its own."""
    targets = UsdRender.Settings(prim).GetProductsRel().GetForwardedTargets()
    products = [each for each in (prim.GetStage().GetPrimAtPath(target) for target in targets) if each]
    for target in targets:
        if not prim.GetStage().GetPrimAtPath(target):
            lost.add("usd-missing", prim, f"there is no product {target}")
    for other in products[1:]:
        lost.add(KIND, other, "a second product is not carried: import once for each")
    for product in products[:1]:
        kinds = UsdRender.Product(product).GetOrderedVarsRel().GetForwardedTargets()
        names = [str(prim.GetStage().GetPrimAtPath(each).GetAttribute("sourceName").Get() or each.name)
                 for each in kinds if prim.GetStage().GetPrimAtPath(each)]  # fmt: skip
        others = [name for name in names if name not in ("Ci", "color", "rgba", "rgb", "RGBA", "LdrColor")]
        if others:
            lost.add(KIND, product, f"its variables {', '.join(others)} are not carried: ask for passes by --passes")
    return products[0] if products else None


def _read_camera(prim: Usd.Prim, product: Usd.Prim | None, found: dict, lost: Losses) -> None:
    for asking in (product, prim):
        if not asking:
            continue
        for target in UsdRender.SettingsBase(asking).GetCameraRel().GetForwardedTargets()[:1]:
            camera = prim.GetStage().GetPrimAtPath(target)
            if camera and camera.IsA(UsdGeom.Camera):
                found["camera"] = target
                return
            lost.add("usd-missing", asking, f"its camera {target} is none; the first there is is taken")


def _value(product: Usd.Prim | None, prim: Usd.Prim, name: str, source: Source):
    """Value of the product if authored, else of the settings; None without either."""
    of_product = _authored(product, name, source) if product else None
    return _authored(prim, name, source) if of_product is None else of_product


def _authored(prim: Usd.Prim, name: str, source: Source):
    """Authored value; None otherwise."""
    attribute = prim.GetAttribute(name)
    return attribute.Get(source.first) if attribute and attribute.HasAuthoredValue() else None


def _say_the_rest(prim: Usd.Prim, lost: Losses) -> None:
    """Reports later properties of the schema, and those of other renderers."""
    usual = set(prim.GetPrimDefinition().GetPropertyNames())
    for name in sorted(set(prim.GetAuthoredPropertyNames()) - READ):
        if name in usual and (attribute := prim.GetAttribute(name)) and attribute.HasAuthoredValue():
            lost.add(KIND, prim, f"its {name} is not carried")


def _say_shape(source: Source, prim: Usd.Prim, found: dict, lost: Losses) -> None:
    """A picture with another aspect than the camera's keeps the height, whatever the policy."""
    if "camera" not in found:
        return
    camera = UsdGeom.Camera(source.stage.GetPrimAtPath(found["camera"]))
    wide, high = (float(each.Get(source.first) or 0) for each in (camera.GetHorizontalApertureAttr(), camera.GetVerticalApertureAttr()))
    if wide <= 0 or high <= 0:
        return
    picture, lens = found["resolution"][0] / found["resolution"][1], wide / high
    policy = str(UsdRender.SettingsBase(prim).GetAspectRatioConformPolicyAttr().Get() or "expandAperture")
    keeps_height = policy == "adjustApertureWidth" or (policy == "expandAperture") == (picture > lens)
    if abs(math.log(picture / lens)) > NEARLY and not (keeps_height and policy in ("adjustApertureWidth", "expandAperture", "cropAperture")):
        lost.add(KIND, prim, f"its aspectRatioConformPolicy {policy} is not carried: the camera's height is kept")
