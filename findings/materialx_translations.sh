#!/usr/bin/env bash
# MaterialX's own translations turn a green leaf grey and glass into a wall, and tint what lies under a coat twice.
#
# Expected: `ShaderTranslator` and its graphs carry a material from Standard Surface to UsdPreviewSurface, OpenPBR and
# glTF PBR, so that each shows nearly the same; what one cannot have is said. What happens with MaterialX 1.39.5:
# `subsurface` at 1 replaces the base colour, so a leaf of 0.1 0.5 0.05 is that for USD, and 0.8, the grey of the unused
# `base_color`, for glTF. Glass is opaque for USD, as `transmission` has no part in its `opacity`. Over white a coat of
# colour 0.5 leaves a half of the light; for OpenPBR both the base and the coat are at 0.5, so a quarter is left. What
# glows under it is at 0.5 for USD and at 1 for glTF. An `opacity` of 0.2 0.5 0.8 is 0.50 for USD, its mean, 0.43 for
# glTF, its luminance, and 0.20 for OpenPBR, red alone, so that a leaf has three masks. `validate` finds no fault, and
# nothing is said.
# Remedy: after the translation set `base_color` of glTF, `opacity` of USD, and `base_color` or `coat_color` of OpenPBR.
# Versions: MaterialX 1.39.5 (PyPI). Source: measured here, by the nodes of the graphs as MaterialX defines them;
# https://github.com/AcademySoftwareFoundation/MaterialX (libraries/bxdf/translation; issues 1903, 2578);
# https://autodesk.github.io/standard-surface/ (subsurface, coat, transparency);
# https://academysoftwarefoundation.github.io/OpenPBR/ (coat)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet materialx==1.39.5
cat >translate.py <<'END'
import math

import MaterialX as mx
from MaterialX.PyMaterialXGenShader import ShaderTranslator

library = mx.createDocument()
mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)


def both(function):
    """`function` of numbers, component by component, as MaterialX has it for colours and vectors."""
    def over(a, b):
        width = max(len(a), len(b))
        return [function(x, y) for x, y in zip(a * (width // len(a)), b * (width // len(b)))]
    return over


NODES = {  # The nodes of MaterialX that these graphs have, by their specification.
    "dot": lambda i: i["in"], "constant": lambda i: i["value"],
    "multiply": lambda i: both(lambda x, y: x * y)(i["in1"], i["in2"]),
    "divide": lambda i: both(lambda x, y: x / y)(i["in1"], i["in2"]),
    "mix": lambda i: both(lambda x, y: x + y)(
        both(lambda x, m: x * m)(i["fg"], i["mix"]), both(lambda x, m: x * (1 - m))(i["bg"], i["mix"])),
    "convert": lambda i: i["in"] * (3 // len(i["in"])),
    "dotproduct": lambda i: [sum(x * y for x, y in zip(i["in1"], i["in2"]))],
    "extract": lambda i: [i["in"][int(i["index"][0])]],
    "luminance": lambda i: [sum(x * y for x, y in zip(i["in"], i["lumacoeffs"]))] * 3,
    "ifequal": lambda i: i["in1"] if i["value1"] == i["value2"] else i["in2"],
    "ifgreater": lambda i: i["in1"] if i["value1"] > i["value2"] else i["in2"],
}


def numbers(value):
    return [float({"true": 1, "false": 0, "": 0}.get(part, part)) for part in value.split(",")]


def value_of(node, given):
    """What a node of a translation gives, where the material has `given`."""
    inputs = {}
    for default in node.getNodeDef().getInputs():
        port, name = node.getInput(default.getName()), default.getName()
        if port is None:
            inputs[name] = numbers(default.getValueString())
        elif port.getInterfaceName():
            inputs[name] = given[port.getInterfaceName()]
        elif port.getNodeName():
            inputs[name] = value_of(node.getParent().getChild(port.getNodeName()), given)
        else:
            inputs[name] = numbers(port.getValueString())
    return NODES[node.getCategory()](inputs)


def translated(target, output, **material):
    """`output` of the shader `target` for a Standard Surface that has `material`."""
    document = mx.createDocument()
    document.setDataLibrary(library)
    shader = document.addNode("standard_surface", "shader", "surfaceshader")
    for name, value in material.items():
        shader.setInputValue(name, mx.Color3(*value) if isinstance(value, tuple) else value)
    document.addMaterialNode("material", shader)
    ShaderTranslator.create().translateAllMaterials(document, target)
    is_valid, fault = document.validate()
    if not is_valid:
        raise SystemExit(f"this has changed: {fault}")
    port = document.getNode("shader").getInput(output)
    if port is None:
        return None
    graph = document.getNodeGraph(port.getNodeGraphString())
    node = graph.getNode(graph.getOutput(port.getOutputString()).getNodeName())
    definition = node.getNodeDef()
    given = {}
    for default in definition.getInputs():
        port = node.getInput(default.getName())
        given[default.getName()] = numbers((port or default).getValueString())
    inside = definition.getImplementation()
    return value_of(inside.getNode(inside.getOutput(f"{output}_out").getNodeName()), given)


mask = {"opacity": (0.2, 0.5, 0.8)}
leaf = {"subsurface": 1.0, "subsurface_color": (0.1, 0.5, 0.05)}
glass = {"transmission": 1.0}
coat = {"base_color": (1.0, 1.0, 1.0), "coat": 1.0, "coat_color": (0.5, 0.5, 0.5)}
neon = {"emission": 1.0, **coat}
USD, OPEN_PBR, GLTF = "UsdPreviewSurface", "open_pbr_surface", "gltf_pbr"
is_same = True
for target, output, material, wanted in [
    (USD, "diffuseColor", leaf, [0.1, 0.5, 0.05]), (OPEN_PBR, "subsurface_color", leaf, [0.1, 0.5, 0.05]),
    (GLTF, "base_color", leaf, [0.8, 0.8, 0.8]),
    (USD, "opacity", glass, [1.0]), (OPEN_PBR, "transmission_weight", glass, [1.0]), (GLTF, "transmission", glass, [1.0]),
    (USD, "diffuseColor", coat, [0.5, 0.5, 0.5]), (GLTF, "base_color", coat, [0.5, 0.5, 0.5]),
    (OPEN_PBR, "base_color", coat, [0.5, 0.5, 0.5]), (OPEN_PBR, "coat_color", coat, [0.5, 0.5, 0.5]),
    (OPEN_PBR, "coat_weight", coat, [1.0]),
    (USD, "emissiveColor", neon, [0.5, 0.5, 0.5]), (GLTF, "emissive", neon, [1.0, 1.0, 1.0]),
    (GLTF, "emissive_strength", neon, [1.0]),
    (USD, "opacity", mask, [0.5]), (GLTF, "alpha", mask, [0.434]), (OPEN_PBR, "geometry_opacity", mask, [0.2]),
]:
    found = translated(target, output, **material)
    print("MaterialX", mx.__version__, target, output, "of", material, [round(part, 3) for part in found])
    is_same &= len(found) == len(wanted) and all(math.isclose(a, b, abs_tol=0.01) for a, b in zip(found, wanted))
if not is_same:
    raise SystemExit("this has changed")
END
venv/bin/python translate.py
