"""The options are one table, the same in Python, Jupyter, Panel and JavaScript; the bundle belongs to its sources."""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import traitlets

from engines.errors import OutOfRangeError, UnknownLabelError
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton
from tests.viewers.web.synthetic import walk
from viewers import bodies
from viewers.scene import PALETTE
from viewers.web import controls, payload
from viewers.web.controls import BUNDLE, FROM_BROWSER, OPTIONS, PAYLOADS
from viewers.web.jupyter import MotionPlayer
from viewers.web.panel_player import PanelPlayer
from viewers.web.payload import Actor

WEB = BUNDLE.parent
BOTH = pytest.mark.parametrize("kind", [MotionPlayer, PanelPlayer])


def test_javascript_knows_the_same_options_and_defaults():
    source = (WEB / "src/options.js").read_text(encoding="utf-8")
    table = source.split("export const OPTIONS = {")[1].split("\n};")[0]
    names = set(re.findall(r"^  (\w+):", table, flags=re.MULTILINE))
    assert names == set(OPTIONS) - {"frame", *FROM_BROWSER, *PAYLOADS}
    for name, values in re.findall(r"^  (\w+): oneOf\((.*)\),$", table, flags=re.MULTILINE):
        if "..." not in values:
            listed = json.loads(f"[{values}]")
            assert (listed[0], set(listed)) == (OPTIONS[name].default, set(OPTIONS[name].choices)), name


@BOTH
def test_every_option_is_a_trait_or_parameter(kind: Any):
    player = kind(walk(1.0), body="stick")
    for name, option in OPTIONS.items():
        if name not in PAYLOADS:
            assert getattr(player, name) == option.default, name
    if kind is MotionPlayer:
        assert set(OPTIONS) <= set(player.traits(sync=True))
    else:
        assert set(OPTIONS) <= set(player.param)


@BOTH
def test_changes_are_announced(kind: Any):
    player, seen = kind(walk(1.0), body="stick"), []
    if kind is MotionPlayer:
        player.observe(lambda change: seen.append(change["new"]), "frame")
    else:
        player.param.watch(lambda event: seen.append(event.new), "frame")
    player.frame = 7
    player.step(-2)
    player.step(100)
    assert seen == [7, 5, 19]


@BOTH
def test_new_motions_do_not_send_the_body_again(kind: Any):
    player, sent = kind(walk(1.0), body="stick"), []
    if kind is MotionPlayer:
        player.observe(lambda change: sent.append(change["name"]), ["body_data", "take_data"])
    else:
        player.param.watch(lambda *events: sent.extend(e.name for e in events), ["body_data", "take_data"])
    player.motions = [walk(2.0), walk(1.5)]
    assert sent == ["take_data"]
    assert [len(motion) for motion in player.motions] == [40, 30]
    assert player.payload_bytes == (len(player.body_data), len(player.take_data))


@BOTH
def test_bad_options_are_named(kind: Any):
    with pytest.raises(UnknownLabelError, match="ghosts"):
        kind(walk(1.0), body="stick", gosts=3)
    with pytest.raises(UnknownLabelError, match="skeleton"):
        kind(walk(1.0), body="stick", show="skelton")
    with pytest.raises(OutOfRangeError, match=r"0\.1 to 4"):
        kind(walk(1.0), body="stick", speed=9.0)
    with pytest.raises(OutOfRangeError, match="one for each of the 1 motions"):
        kind(walk(1.0), body="stick", labels=["a", "b"])
    with pytest.raises(UnknownLabelError, match="anny"):
        kind(walk(1.0), body="any")


@BOTH
def test_values_set_later_are_checked_too(kind: Any):
    player = kind(walk(1.0), body="stick")
    with pytest.raises((traitlets.TraitError, ValueError)):
        player.speed = 9.0
    with pytest.raises((traitlets.TraitError, ValueError)):
        player.loop = "some"


def test_names_and_colours():
    plain, named = controls.actors_of([walk(1.0), Actor(walk(1.0), "b", "#ff0000")])
    assert (plain.name, named.name) == ("Take 1", "b")
    assert (plain.colour, named.colour) == (PALETTE[0], "#ff0000")
    assert controls.actors_of(walk(1.0))[0].name == ""
    assert [a.name for a in controls.actors_of([walk(1.0)] * 2, ["x", "y"])] == ["x", "y"]


def test_other_bone_lengths_share_the_body():
    tall = walk(1.0, skeleton=SMPL22.scaled({"left_knee": 1.2, "right_knee": 1.2}))
    body, played = controls.dress([walk(1.0), tall], "anny")
    assert body is bodies.get("anny")
    assert played[1] is tall


def test_other_joints_are_retargeted_and_keep_their_skeleton_without_a_body():
    names = tuple(f"{joint}_x" if joint == "spine2" else joint for joint in SMPL22.joints)
    other = SMPL22.replaced(name="other", joints=names)
    moved = Motion(other, walk(1.0).rotations, walk(1.0).translation, 20.0)
    body, (played,) = controls.dress([moved], None)
    assert body is None
    assert played is moved
    stick, (same,) = controls.dress([moved], "stick")
    assert stick is not None
    assert (stick.skeleton, same) == (other, moved)
    _, (retargeted,) = controls.dress([moved], "anny")
    assert retargeted.skeleton == SMPL22


def test_single_joint_plays():
    dot = Motion(Skeleton("dot", ("root",), (-1,), np.zeros((1, 3))), np.ones((3, 1, 4)), np.zeros((3, 3)), 10.0)
    header, arrays = payload.unpack(controls.encode(controls.actors_of(dot), None)[1])
    assert header["skeletons"][0]["feet"] == []
    assert arrays["contacts0"].shape == (3, 0)


def test_frameworks_are_imported_only_when_asked_for():
    code = (
        "import sys; import viewers.web.player; print([m for m in ('anywidget', 'panel', 'torch') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "[]"


def test_bundle_belongs_to_the_sources():
    digest = hashlib.sha256()
    sources = [p for p in (WEB / "src").rglob("*") if p.suffix in (".js", ".css")]
    for path in sorted(sources, key=lambda p: p.relative_to(WEB / "src").as_posix()):
        digest.update(path.relative_to(WEB / "src").as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    with BUNDLE.open(encoding="utf-8") as file:
        assert digest.hexdigest() in file.readline(), "the sources changed: npm run build in viewers/web"


def test_bundle_carries_the_licence_of_what_is_in_it():
    text = BUNDLE.read_text(encoding="utf-8")
    assert "Three.js Authors" in text
    assert "The above copyright notice and this permission notice shall be included" in text
    assert "three.js" in (WEB / "THIRD_PARTY.md").read_text(encoding="utf-8")


def test_lock_file_names_no_registry():
    lock = json.loads((WEB / "package-lock.json").read_text(encoding="utf-8"))
    assert all("resolved" not in package for package in lock["packages"].values())
    assert all("integrity" in package for name, package in lock["packages"].items() if name)


def test_html_is_one_file_that_fetches_nothing(tmp_path: Path):
    from viewers.web.player import save_html

    path = save_html(walk(1.0), tmp_path / "a.html", body="stick", title="<b> & co")
    text = path.read_text(encoding="utf-8")
    assert "<title>&lt;b&gt; &amp; co</title>" in text
    assert not re.search(r"""(src|href)=["'](https?:)?//""", text)
    assert [p.name for p in tmp_path.iterdir()] == ["a.html"]
    assert text.count("</script>") == 3


def test_html_that_fails_leaves_nothing(tmp_path: Path):
    from viewers.web.player import save_html

    with pytest.raises(UnknownLabelError):
        save_html(walk(1.0), tmp_path / "a.html", body="stick", camera="above")
    assert list(tmp_path.iterdir()) == []


def test_embedded_player_carries_what_it_shows():
    player = MotionPlayer(walk(1.0), body="stick", ghosts=3, frame=4)
    shown = player.embed()._repr_html_()
    assert shown.startswith("<iframe srcdoc=")
    assert "&quot;ghosts&quot;: 3" in shown
    assert "&quot;frame&quot;: 4" in shown
