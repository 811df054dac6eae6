#!/usr/bin/env bash
# A program in a Blender extension cannot be run once the extension is installed.
#
# Expected: files of an extension's zip keep their mode, as `unzip` keeps it: a program that is 0755 there can be
# run where Blender has put it. What happens: Blender 5.0.1 and 5.3.0 unpack without modes, and say nothing;
# their `validate` does not either. Starting the program fails with *Permission denied*.
# Remedy: the add-on sets the mode of its program before it first runs it.
# Source: https://projects.blender.org/blender/blender (scripts/addons_core/bl_pkg/cli/blender_ext.py)
# Needs python3.13 with venv. Ends with 1 if it has changed. Run with bpy 5.3.0 and 5.0.1 on 2026-11-27.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >install.py <<'END'
import os
import stat
import zipfile

import bpy

MANIFEST = """schema_version = "1.0.0"
id = "carries_a_program"
version = "1.0.0"
name = "Carries a program"
tagline = "An extension with a program inside"
maintainer = "nobody"
type = "add-on"
blender_version_min = "5.0.0"
license = ["SPDX:MIT"]
"""
with zipfile.ZipFile("carries_a_program.zip", "w") as archive:
    for name, text, mode in (
        ("blender_manifest.toml", MANIFEST, 0o644),
        ("__init__.py", "def register(): pass\ndef unregister(): pass\n", 0o644),
        ("bin/tool", "#!/bin/sh\necho runs\n", 0o755),
    ):
        entry = zipfile.ZipInfo(name)
        entry.external_attr = (stat.S_IFREG | mode) << 16
        archive.writestr(entry, text)
path = os.path.abspath("carries_a_program.zip")
bpy.ops.extensions.package_install_files(filepath=path, repo="user_default", enable_on_install=True)
import bl_ext.user_default.carries_a_program as installed

tool = os.path.join(os.path.dirname(installed.__file__), "bin", "tool")
mode = stat.S_IMODE(os.stat(tool).st_mode)
print(f"bpy {bpy.app.version_string}: bin/tool is 0o755 in the zip and {oct(mode)} where it is installed")
raise SystemExit(0 if not mode & 0o111 else 1)
END
BLENDER_USER_RESOURCES=$folder/profile venv/bin/python install.py 2>&1 | grep "^bpy"
