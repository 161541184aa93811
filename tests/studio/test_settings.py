from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engines.errors import FormatError, OutOfRangeError, UnknownLabelError
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

generate = st.integers(1, 32).flatmap(
    lambda count: st.builds(
        GenerateSettings,
        action=st.text(min_size=1, max_size=20),
        frames=st.integers(2, 12000),
        seed=st.integers(0, 2**31 - 1),
        count=st.just(count),
        take=st.none() | st.integers(1, count),
        bone_scale=st.dictionaries(st.sampled_from(["left_knee", "*"]), st.floats(0.5, 2.0), max_size=2),
    )
)
export = st.builds(
    ExportSettings,
    formats=st.lists(st.sampled_from(FORMATS), min_size=1, max_size=4, unique=True),
    width=st.none() | st.integers(32, 2048).map(lambda n: 2 * n),
    height=st.none() | st.integers(32, 2048).map(lambda n: 2 * n),
    fps=st.none() | st.floats(1, 240),
    camera=st.sampled_from(CAMERAS),
)


@given(st.builds(Settings, generate, export))
def test_text_brings_the_same_settings_back(settings):
    assert parse_settings(settings.to_json()) == settings


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
        ('{"export": {"formats": ["mp5"]}}', "did you mean 'mp4'"),
        ('{"export": {"formats": "mp4"}}', "accepted: list"),
        ('{"export": {"width": 641}}', "an even number of pixels"),
        ('{"export": {"camera": "top"}}', "unknown camera 'top'"),
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
