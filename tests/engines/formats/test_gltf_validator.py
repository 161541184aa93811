"""Khronos' own validator finds nothing wrong with our .glb files, where Node.js and the package are there.

It is a development package of the player: `cd viewers/web && npm ci`. Without it `test_glb.py` checks the same rules.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from engines import formats
from tests.engines.formats.conftest import random_motion
from tests.viewers.textured import gradient, textured
from viewers.bodies import body_for

WEB = Path(__file__).resolve().parents[3] / "viewers" / "web"
SCRIPT = """
const validator = require("gltf-validator");
const data = new Uint8Array(require("fs").readFileSync(process.argv[1]));
validator.validateBytes(data).then((report) => console.log(JSON.stringify(report)));
"""
pytestmark = pytest.mark.skipif(
    shutil.which("node") is None or not (WEB / "node_modules" / "gltf-validator").is_dir(),
    reason="no gltf-validator: cd viewers/web && npm ci",
)


def report(path: Path) -> dict:
    done = subprocess.run(["node", "-e", SCRIPT, str(path)], capture_output=True, text=True, check=True, cwd=WEB)
    return json.loads(done.stdout)


@pytest.mark.parametrize("body", [None, "anny", "stick", textured(gradient())])
def test_nothing_is_wrong(tmp_path, body):
    motion, options = random_motion(12), {}
    if body:
        options["skin"], motion = body_for(motion, body)
    found = report(formats.write(motion, tmp_path / "walk.glb", **options))
    issues = [m for m in found["issues"]["messages"] if m["severity"] < 2]
    assert found["issues"]["numErrors"] == found["issues"]["numWarnings"] == 0, issues[:5]
    assert found["info"]["animationCount"] == 1 and found["info"]["hasSkins"]


def test_it_would_find_something(tmp_path):
    path = formats.write(random_motion(3), tmp_path / "walk.glb")
    data = bytearray(path.read_bytes())
    at = data.index(b'"LINEAR"')
    data[at : at + 8] = b'"LINEAL"'
    path.write_bytes(data)
    assert report(path)["issues"]["numWarnings"] >= 1
