"""`motionloom caption`: sentences of a file, how well they fit, and what is said where weights are missing."""

from __future__ import annotations

import re

import pytest

from engines import registry, weights_file
from engines.errors import CheckpointError
from engines.metrics.evaluators import co_embedding
from studio import captions
from studio.quality import fit
from tests.engines.tm2t import tiny
from tests.studio.fakes import sway


@pytest.fixture
def walk(tmp_path):
    sway(frames=60).write(tmp_path / "walk.bvh")
    return "walk.bvh"


@pytest.fixture
def weights(tmp_path):
    """Those of a network of a few units."""
    model = tiny.model()
    weights_file.write(model.state_dict(), model.config.to_json(), tmp_path / "tiny.safetensors")
    return "tiny.safetensors"


@pytest.fixture
def nobody_judges(monkeypatch):
    monkeypatch.setattr(captions, "judge", lambda: None)


def test_sentences_come_with_how_well_they_fit(run, walk, weights):
    code, out, _ = run("caption", walk, "--checkpoint", weights, "--count", "2")
    lines = out.splitlines()
    assert code == 0
    assert len(lines) == 2
    assert all(re.fullmatch(r"-?\d\.\d\d  \w.+", line) for line in lines)


def test_without_a_judge_they_stand_alone(run, walk, weights, nobody_judges):
    code, out, _ = run("caption", walk, "--checkpoint", weights, "--beams", "4", "-n", "1")
    assert code == 0
    assert len(out.splitlines()) == 1
    assert not re.match(r"-?\d", out)


def test_without_weights_it_is_said_what_makes_them(run, walk, monkeypatch):
    monkeypatch.setattr(registry, "captioners", dict)
    code, _, err = run("caption", walk)
    assert code == 1
    assert "motionloom train tm2t" in err


def test_what_is_not_accepted_is_named(run, walk, weights, nobody_judges):
    code, _, err = run("caption", walk, "--checkpoint", weights, "--count", "17")
    assert code == 1
    assert "count" in err
    assert "1 to 16" in err


def test_a_judge_without_weights_is_none(monkeypatch):
    def missing():
        raise CheckpointError("none here")

    monkeypatch.setattr(co_embedding, "load", missing)
    captions._judge.cache_clear()
    assert captions.judge() is None
    captions._judge.cache_clear()


def test_levels_are_those_of_real_pairs_and_of_other_motions():
    assert [fit(value).level for value in (0.77, 0.64, 0.3)] == ["good", "fair", "poor"]
    assert fit(0.7).real == "0.77"
