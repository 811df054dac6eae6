"""Loading of any input of the renderer as a glTF scene.

Other formats, and glTF with compression, instancing or animated properties, are converted by `sunfleck
export`; so there is only one reader of RON.
"""

import re
import subprocess
import tempfile
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

from ..errors import SceneError, ToolError
from ..program import find_program
from .container import Container
from .scene import Gltf
from .values import Value

READ_HERE = {
    "KHR_lights_punctual", "KHR_materials_clearcoat", "KHR_materials_diffuse_transmission", "KHR_materials_emissive_strength",
    "KHR_materials_ior", "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_unlit",
    "KHR_mesh_quantization", "KHR_node_visibility", "KHR_texture_transform",
}  # fmt: skip
UNREADABLE = 4
"""Exit code of the program."""
WARNING = re.compile(r"^(?:.*: )?(?:warning\[[\w-]+\]: )(.*)$", re.MULTILINE)
"""A loss in what the program says."""
READ_BY_PROGRAM = {
    "EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "EXT_texture_webp", "KHR_animation_pointer",
    "KHR_draco_mesh_compression", "KHR_meshopt_compression",
}  # fmt: skip


def load(
    source: Path,
    program: str | None = None,
    frames: tuple[int, int] | None = None,
    fps: Fraction | None = None,
    allowed: Sequence[Path] = (),
) -> Gltf:
    """Reads a sequence, a scene or a glTF file; frames and rate are the input's own by default. Files that
    a glTF file refers to are read from its own folder and those `allowed`."""
    why = ""
    if source.suffix.lower() in (".glb", ".gltf"):
        container = Container(source, allowed)
        needed = beyond(container.document)
        if not needed:
            return Gltf(container, fps, frames)
        why = f", which reads its {', '.join(needed)}"
    found = find_program(program)
    if found is None:
        raise SceneError(
            f"{source}: needs the program sunfleck{why}, and there is none: give --sunfleck, set SUNFLECK, "
            "or put it on the PATH"
        )
    with tempfile.TemporaryDirectory() as folder:
        exported = Path(folder) / "scene.glb"
        command = [found, "export", str(source), str(exported)]
        command += ["--frames", f"{frames[0]}-{frames[1]}"] if frames else []
        command += ["--fps", str(fps)] if fps else []
        result = subprocess.run(command, capture_output=True, text=True, errors="replace")
        if result.returncode != 0:
            said = result.stderr.strip() or f"{source}: sunfleck export failed"
            raise ToolError(said, is_usage=False) if result.returncode == UNREADABLE else SceneError(said)
        gltf = Gltf(Container(exported))
        gltf.warnings = WARNING.findall(result.stderr)
        return gltf


def beyond(document: Value) -> list[str]:
    """Extensions that are not supported here, and without which the file cannot be shown."""
    required = {value.text() for value in document.items("extensionsRequired")} - READ_HERE
    used = {value.text() for value in document.items("extensionsUsed")} & READ_BY_PROGRAM
    return sorted(required | used)
