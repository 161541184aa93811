from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engines.errors import FormatError, OutOfRangeError, UnknownLabelError
from studio import settings as settings_module
from studio.pinned import JOINTS, JointPin, Kept, Pinned
from studio.settings import (
    CAMERAS,
    FORMATS,
    ExportSettings,
    GenerateSettings,
    Settings,
    parse_settings,
    read_settings,
    write_settings,
)

metres = st.floats(-50, 50)
quaternion = st.sampled_from([(1.0, 0.0, 0.0, 0.0), (0.6, 0.0, 0.8, 0.0), (0.5, -0.5, 0.5, -0.5)])
pins = st.builds(
    JointPin, st.sampled_from(JOINTS), st.integers(0, 100), st.tuples(metres, metres, metres), st.integers(0, 200)
)
kept = st.integers(1, 3).flatmap(
    lambda frames: st.builds(
        Kept,
        st.lists(st.tuples(*[quaternion] * 22), min_size=frames, max_size=frames).map(tuple),
        st.lists(st.tuples(metres, metres, metres), min_size=frames, max_size=frames).map(tuple),
        at=st.integers(0, 100),
        source=st.text(max_size=8),
        parts=st.sampled_from([(), ("left arm",)]),
        placed=st.booleans(),
    )
)
pinned = st.builds(
    Pinned,
    st.lists(kept, max_size=2).map(tuple),
    st.sampled_from([(), ((0.0, 0.0), (0.1, 2.0)), ((1e-7, -3.25), (1 / 3, 2 / 3), (9.0, 0.0))]),
    st.lists(pins, max_size=2).map(tuple),
    st.booleans(),
)
generate = st.integers(1, 32).flatmap(
    lambda count: st.builds(
        GenerateSettings,
        action=st.text(min_size=1, max_size=20),
        frames=st.integers(2, 12000),
        seed=st.integers(0, 2**31 - 1),
        count=st.just(count),
        take=st.none() | st.integers(1, count),
        bone_scale=st.dictionaries(st.sampled_from(["left_knee", "*"]), st.floats(0.5, 2.0), max_size=2),
        style=st.text(max_size=10),
        prompt=st.text(max_size=40) | st.just("[\n 1, 2\n ]"),
        guidance=st.floats(0, 10),
        best_of=st.integers(1, 16),
        constraints=pinned,
    )
)
export = st.builds(
    ExportSettings,
    formats=st.lists(st.sampled_from(FORMATS), min_size=1, max_size=4, unique=True),
    width=st.none() | st.integers(32, 2048).map(lambda n: 2 * n),
    height=st.none() | st.integers(32, 2048).map(lambda n: 2 * n),
    fps=st.none() | st.floats(1, 240),
    camera=st.sampled_from(CAMERAS),
    body=st.sampled_from(["", "anny", "SMPLX_NEUTRAL.npz"]),
    shape=st.dictionaries(st.sampled_from(["weight", "beta1"]), st.floats(-5, 5), max_size=2),
)


@given(st.builds(Settings, generate, export))
def test_text_brings_the_same_settings_back(settings):
    assert parse_settings(settings.to_json()) == settings


def test_a_file_from_before_there_were_styles_and_pins_still_loads():
    text = '{"version": 1, "generate": {"engine": "action2motion", "variant": "lie", "action": "run", "frames": 40}}'
    found = parse_settings(text).generate
    assert (found.engine, found.action, found.style, found.prompt) == ("action2motion", "run", "", "")
    assert not found.constraints


def test_rows_of_numbers_stand_on_one_line():
    turns = (((1.0, 0.0, 0.0, 0.0),) * 22,)
    text = Settings(GenerateSettings(constraints=Pinned((Kept(turns, ((0.0, 0.9, 0.0),)),)))).to_json()
    assert text.count("[1.0, 0.0, 0.0, 0.0]") == 22
    assert len(text.splitlines()) < 80


def test_the_usual_engine_is_one_with_weights(monkeypatch):
    known = {"one": "", "two": ""}
    monkeypatch.setattr(settings_module.engines, "available", lambda: known)
    monkeypatch.setattr(settings_module, "DEFAULT_ENGINE", "two")
    assert GenerateSettings().engine == "two"
    del known["two"]
    assert GenerateSettings().engine == "one"


def test_missing_keys_take_their_defaults():
    settings = parse_settings('{"generate": {"seed": 3}}')
    assert settings == Settings(GenerateSettings(seed=3))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "x.json:1: not JSON"),
        ("[]", "a list"),
        ('{"version": 2}', "settings version 2; accepted: 1"),
        ('{"generate": {"seeds": 1}}', "did you mean 'seed'"),
        ('{"exports": {}}', "did you mean 'export'"),
        ('{"generate": []}', "generate holds a list"),
        ('{"generate": {"frames": "60"}}', 'generate.frames holds "60"; accepted: int'),
        ('{"generate": {"frames": true}}', "generate.frames holds true"),
        ('{"generate": {"frames": 60.5}}', "generate.frames holds 60.5"),
        ('{"generate": {"frames": 1}}', "frames is 1; accepted: 2 to 12,000"),
        ('{"generate": {"count": 2, "take": 3}}', "take is 3; accepted: 1 to 2"),
        ('{"generate": {"bone_scale": {"left_knee": "long"}}}', "accepted: dict"),
        ('{"generate": {"bone_scale": {"left_knee": 9}}}', "bone_scale['left_knee'] is 9"),
        ('{"generate": {"best_of": 0}}', "best_of is 0; accepted: 1 to 16"),
        ('{"generate": {"guidance": 11}}', "guidance is 11; accepted: 0 to 10"),
        ('{"generate": {"guidance": "much"}}', 'generate.guidance holds "much"'),
        ('{"generate": {"prompt": "' + "a" * 1001 + '"}}', "length of the prompt is 1001"),
        ('{"generate": {"constraints": []}}', "generate.constraints holds []; accepted: dict"),
        ('{"generate": {"constraints": {"paths": []}}}', "unknown key of constraints 'paths'; did you mean 'path'"),
        (
            '{"generate": {"constraints": {"path": [[0, 0], [0.1, 0]]}}}',
            "length of the path is '0.10 m'; accepted: 0.3",
        ),
        ('{"generate": {"constraints": {"path": [[0, 0, 0]]}}}', "any number of × 2 numbers"),
        ('{"generate": {"constraints": {"path": [["a", 0]]}}}', "not a table of numbers"),
        ('{"generate": {"constraints": {"path": [[0, 0], [NaN, 9]]}}}', "finite numbers"),
        ('{"generate": {"constraints": {"loop": 1}}}', "constraints.loop is 1; accepted: true or false"),
        (
            '{"generate": {"constraints": {"pins": [{"joint": "left_hand", "frame": 1, "position": [0, 1, 0]}]}}}',
            "unknown joint to pin 'left_hand'; did you mean 'left_",
        ),
        (
            '{"generate": {"constraints": {"pins": [{"joint": "head", "frame": -1, "position": [0, 1, 0]}]}}}',
            "frame of the pin of head is -1",
        ),
        ('{"generate": {"constraints": {"pins": [{"joint": "head"}]}}}', "constraints.pins: "),
        (
            '{"generate": {"constraints": {"kept": [{"rotations": [[1, 0, 0, 0]], "translation": [[0, 0, 0]]}]}}}',
            "any number of × 22 × 4 numbers",
        ),
        ('{"export": {"formats": ["mp5"]}}', "did you mean 'mp4'"),
        ('{"export": {"formats": "mp4"}}', "accepted: list"),
        ('{"export": {"width": 641}}', "an even number of pixels"),
        ('{"export": {"camera": "top"}}', "unknown camera 'top'"),
        ('{"export": {"views": "all"}}', "unknown views 'all'"),
    ],
)
def test_what_is_not_understood_is_refused_with_what_is(text, says):
    with pytest.raises(FormatError) as refused:
        parse_settings(text, "x.json")
    assert says in str(refused.value)
    assert str(refused.value).startswith("x.json")


def test_options_on_top_of_a_file_find_their_section():
    changed = Settings().changed(seed=5, camera="front", fps=None)
    assert changed == Settings(GenerateSettings(seed=5), ExportSettings(camera="front"))


def test_unknown_option_is_named():
    with pytest.raises(UnknownLabelError, match="'camera'"):
        Settings().changed(camra="front")


def test_seed_beyond_the_range_is_refused():
    with pytest.raises(OutOfRangeError, match=r"0 to 2,147,483,647"):
        GenerateSettings(seed=2**31)


def test_file_round_trip_leaves_nothing_beside(tmp_path):
    settings = Settings(GenerateSettings(action="jump", bone_scale={"*": 1.1}))
    path = write_settings(settings, tmp_path / "take-2.json")
    assert read_settings(path) == settings
    assert [p.name for p in tmp_path.iterdir()] == ["take-2.json"]
    assert json.loads(path.read_text())["version"] == 1


def test_missing_and_binary_files_say_so(tmp_path):
    with pytest.raises(FormatError, match="cannot be read"):
        read_settings(tmp_path / "no.json")
    (tmp_path / "bin.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FormatError, match="cannot be read"):
        read_settings(tmp_path / "bin.json")
