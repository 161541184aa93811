"""`motionloom stylize`: what it tells the engine, what it writes, what it says of mistakes."""

from __future__ import annotations

import numpy as np
import pytest

import engines
from engines import registry
from studio import edits, tasks
from studio.settings import read_settings
from tests.studio.fakes import FakeStyliser, sway


@pytest.fixture
def fake(monkeypatch) -> FakeStyliser:
    made = FakeStyliser()
    monkeypatch.setattr(registry, "stylisers", lambda: {made.name: "a stand-in"})
    monkeypatch.setattr(tasks, "load_engine", lambda _name, _variant="": made)
    return made


@pytest.fixture
def walk(tmp_path):
    return sway(frames=40).write(tmp_path / "walk.npz")


def test_a_style_with_standing_feet_held(run, fake, walk):
    code, out, err = run("stylize", str(walk), "--style", "old", "--strength", "0.5", "--seed", "3", "-o", "old.npz")
    assert (code, out.strip(), err) == (0, "old.npz", "")
    assert fake.calls == [{"frames": 59, "style": "old", "like": None, "strength": 0.5, "count": 1, "seed": 3}]
    plain = fake.stylise(sway(frames=40).resample(30), "old", strength=0.5, seed=3)[0]
    made = engines.read("old.npz")
    np.testing.assert_allclose(made.positions, edits.apply(plain, ["feet"]).positions, atol=1e-4)
    assert (made.label_at(0), made.label_at(0, "style")) == ("walk", "old")


def test_like_a_file_and_the_same_again_by_its_settings(run, fake, walk, tmp_path):
    other = sway("wave", frames=30).write(tmp_path / "wave.bvh")
    first = run("stylize", str(walk), "--like", str(other), "-n", "2", "--no-feet", "--save-settings", "all.json")
    assert first[0] == 0
    assert fake.calls[-1]["like"] == len(read_settings("all.json").generate.like.motion)
    names = first[1].split()
    assert names[0].startswith("walk-as-in-wave-bvh-seed7-1")
    before = engines.read(names[1]).rotations
    assert run("stylize", "--settings", "all.json", "--take", "2", "-o", "again.bvh")[0] == 0
    np.testing.assert_array_equal(engines.read("again.bvh").rotations, before)
    assert run("generate", "--settings", "all.json", "--take", "2", "-o", "so.bvh")[0] == 0
    np.testing.assert_array_equal(engines.read("so.bvh").rotations, before)


def test_by_chance_and_the_styles_there_are(run, fake, walk):
    assert run("stylize", str(walk), "-o", "any.bvh")[0] == 0
    assert fake.calls[-1]["style"] is None
    assert run("stylize", "--list-styles")[1].split() == list(fake.styles)
    code, out, _ = run("info", "restyler")
    assert code == 0 and "3: happy, old, tired" in out


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["{walk}", "--style", "odl"], 1, "'old'"),
        (["{walk}", "--strength", "2"], 1, "0 to 1.5"),
        (["{short}", "--style", "old"], 1, "8 to 18,000"),
        (["missing.bvh"], 1, "missing.bvh"),
        (["{walk}", "--style", "old", "--like", "{walk}"], 2, "not both"),
        ([], 2, "INPUT"),
        (["{walk}", "--tempo"], 1, "takes no tempo"),
    ],
)
def test_mistakes_are_said_and_nothing_is_written(run, fake, walk, tmp_path, arguments, code, says):  # noqa: PLR0917
    short = sway(frames=3).write(tmp_path / "short.npz")
    told = [text.format(walk=walk, short=short) for text in arguments]
    came, out, err = run("stylize", *told, "-o", "out")
    assert (came, out) == (code, "")
    assert says in err
    assert not (tmp_path / "out").exists()


def test_without_weights_it_says_so(run, monkeypatch, walk):
    monkeypatch.setattr(registry, "stylisers", dict)
    assert "no engine" in run("stylize", str(walk))[2]
