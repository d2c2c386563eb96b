"""The scripts of the pages: their types, meshcat's private names, and where those are used."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from pilegrasp_ctrl.viewer.browser import LIVE_SCRIPTS, PAGE_SCRIPTS, STUDY_SCRIPTS, own_script, viewer_script

FOLDER = Path(__file__).parents[2] / "viewer" / "browser"

PRIVATE_NAMES = {
    "scene_tree": "this.scene_tree=new SceneNode(",
    "find": "find(e){if(0==e.length)return this;",
    "children": "this.object=e,this.folder=t,this.children={}",
    "gui": "this.gui=new dat.GUI({autoPlace:!1})",
    "handle_command_bytearray": "handle_command_bytearray(",
    "set_dirty": "set_dirty(){this.needs_render=!0}",
    "needs_render": "this.needs_render&&this.render()",
    "render": "render(){this.controls.update()",
    "set_3d_pane_size": "set_3d_pane_size(e,t)",
    "animator": "this.animator=new Animator(this)",
    "actions": "this.actions.push(",
    "seek": "seek(e){this.actions.forEach(",
    "camera": "set_camera(e){this.camera=e",
    "controls": "this.controls=new",
    "renderer": "this.renderer.setPixelRatio(",
}
"""Names of meshcat's viewer that `meshcat.js` and the cameras use, and the text of the bundle that gives each its
meaning."""


@pytest.mark.parametrize("name", PRIVATE_NAMES)
def test_meshcats_bundle_still_has_the_private_names_that_we_use(name):
    assert PRIVATE_NAMES[name] in viewer_script(), (
        f"this release of meshcat changed `{name}`; adapt viewer/browser/meshcat.js, then this table"
    )


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.js")), ids=lambda file: file.name)
def test_private_names_are_used_in_one_file_only(file):
    text = re.sub(r"//.*", "", file.read_text(encoding="utf-8"))
    if file.name != "meshcat.js":
        found = re.findall(r"scene_tree|\.animator|\.gui\b|handle_command|needs_render|set_dirty|MeshCat\b", text)
        assert not found


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.js")), ids=lambda file: file.name)
def test_every_script_asks_to_be_checked(file):
    assert file.read_text(encoding="utf-8").startswith("// @ts-check\n")


def test_the_scripts_have_no_type_errors():
    program = shutil.which("tsc")
    if program is None:
        reason = "tsc is not installed; on Debian, `apt-get install node-typescript`"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    checked = subprocess.run([program, "-p", str(FOLDER)], capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout


def test_a_page_carries_each_script_once():
    assert len(set(PAGE_SCRIPTS)) == len(PAGE_SCRIPTS)
    listed = {*PAGE_SCRIPTS, *LIVE_SCRIPTS, *STUDY_SCRIPTS, "picture.js"}
    assert {file.name for file in FOLDER.glob("*.js")} == listed
    text = own_script(*PAGE_SCRIPTS)
    assert "// " not in "".join(line for line in text.splitlines() if line.startswith("//"))


def test_the_page_names_the_licence_of_every_bundled_package():
    script = viewer_script()
    for package in ("dat.gui", "three", "msgpack", "ccapture.js"):
        assert package in script.split("*/")[0]
