#!/usr/bin/env bash
# What a render engine makes while it renders costs it Persistent Data: the next render is told that all changed.
#
# Expected: with *Persistent Data* an engine's `depsgraph.updates` names what was edited since the last render;
# after a turned camera that is one object. What happens: if `render()` has made and removed a node group, in no
# way connected with the scene, the next render of Blender 5.3.0 lists every object, mesh and material.
# The numbers on 2026-11-27: 1 and 6, which is all of the default scene (bpy 5.0.1 has them too).
# Remedy: make what is needed in a `render_init` handler, before Blender evaluates the graph.
# Source: https://docs.blender.org/api/current/bpy.types.Depsgraph.html (updates)
# Needs python3.13 with venv. Ends with 1 if it has changed. Run with bpy 5.3.0 on 2026-11-27.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >updates.py <<'END'
import bpy

told, makes = [], [False]


class Engine(bpy.types.RenderEngine):
    bl_idname, bl_label = "COUNTS_UPDATES", "Counts updates"

    def render(self, depsgraph):
        told.append(len(depsgraph.updates))
        if makes[0]:
            bpy.data.node_groups.remove(bpy.data.node_groups.new("made", "ShaderNodeTree"))
        self.end_result(self.begin_result(0, 0, self.resolution_x, self.resolution_y))


bpy.utils.register_class(Engine)
scene = bpy.context.scene
scene.render.engine, scene.render.use_persistent_data = "COUNTS_UPDATES", True
scene.render.resolution_x = scene.render.resolution_y = 8
for makes[0] in (False, True):
    for _ in range(3):
        bpy.ops.render.render()
        scene.camera.rotation_euler.z += 0.1
print(f"bpy {bpy.app.version_string}: updates of a turned camera: {told[2]}; where a node group was made: {told[5]}")
raise SystemExit(0 if told[2] == 1 and told[5] > 5 else 1)
END
venv/bin/python updates.py 2>&1 | grep "^bpy"
