from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import engines
from engines import __version__
from engines.errors import Cancelled
from studio import tasks
from studio.settings import (
    FORMATS,
    VIDEO_FORMATS,
    ExportSettings,
    GenerateSettings,
    Settings,
    ending,
    read_settings,
    write_settings,
)
from tests.studio.fakes import sway


def test_version(run):
    assert run("--version") == (0, f"motionloom {__version__}\n", "")


@pytest.mark.parametrize("command", ["studio", "generate", "render", "convert", "info"])
def test_help_of_every_command_has_examples(run, command):
    code, out, _ = run(command, "--help")
    assert code == 0
    assert "Examples" in out
    assert f"motionloom {command}" in out


def test_help_lists_the_commands(run):
    code, out, _ = run("--help")
    assert code == 0
    for command in ("studio", "generate", "render", "convert", "info"):
        assert f" {command} " in out


@pytest.mark.parametrize(
    "arguments", [["dance"], ["generate"], ["generate", "walk", "--frames", "many"], ["convert", "a"]]
)
def test_wrong_usage_is_code_2(run, arguments):
    code, _out, err = run(*arguments)
    assert code == 2
    assert err


def test_generate_writes_every_motion_in_every_format(run, engine, tmp_path):
    code, out, _ = run("generate", "walk", "-n", "2", "--frames", "12", "--seed", "3", "-o", "out", "-f", "bvh,npz")
    assert code == 0
    names = [f"walk-seed3-{i}.{kind}" for i in (1, 2) for kind in ("bvh", "npz")]
    assert out.split() == [f"out/{name}" for name in names]
    motion = engines.read(tmp_path / "out" / "walk-seed3-2.npz")
    np.testing.assert_array_equal(motion.rotations, sway("walk", 12, 3, 1).rotations)
    assert engine.calls == [{"action": "walk", "count": 2, "frames": 12, "seed": 3}]


def test_generate_into_one_file_draws_one(run, engine, tmp_path):
    code, out, _ = run("generate", "wave left hand", "--frames", "12", "-o", "wave.amass.npz")
    assert (code, out) == (0, "wave.amass.npz\n")
    assert engine.calls[0]["count"] == 1
    assert engines.read(tmp_path / "wave.amass.npz").frames == 12


def test_generate_by_settings_file_repeats_the_take(run, engine, tmp_path):
    settings = Settings(GenerateSettings(action="run", frames=12, seed=5, count=4, take=3))
    write_settings(settings, tmp_path / "take-3.json")
    code, out, _ = run("generate", "--settings", "take-3.json", "-f", "npz", "--save-settings", "used.json")
    assert (code, out.split()) == (0, ["run-seed5-3.npz", "used.json"])
    motion = engines.read(tmp_path / "run-seed5-3.npz")
    np.testing.assert_array_equal(motion.rotations, sway("run", 12, 5, 2).rotations)
    assert engine.calls[0]["count"] == 4, "the whole draw, so that the bits agree"
    assert read_settings(tmp_path / "used.json").generate == settings.generate


def test_options_win_over_the_settings_file(run, engine, tmp_path):
    write_settings(Settings(GenerateSettings(action="run", frames=12)), tmp_path / "s.json")
    code, _, _ = run("generate", "walk", "-s", "s.json", "--seed", "9", "-n", "1", "--bone-scale", "left_knee=1.1")
    assert code == 0
    assert engine.calls == [{"action": "walk", "count": 1, "frames": 12, "seed": 9, "bone_scale": {"left_knee": 1.1}}]


def test_words_style_and_pins_reach_the_engine(run, constrained, tmp_path):
    sway(frames=60).write(tmp_path / "walk.npz")
    code, out, err = run(
        "generate", "--prompt", "a person walks far", "--style", "old", "--guidance", "3", "--best-of", "2", "-n", "1",
        "--path", "0,0 0,2 3,6", "--begin-with", "walk.npz:20", "--pose", "walk.npz:30@50", "--loop",
        "-f", "npz", "--save-settings", "used.json",
    )  # fmt: skip
    assert (code, out.split()) == (0, ["a-person-walks-far-seed7-1.npz", "used.json"])
    assert err == "not met: The path is 7.0 m long; it is followed for 5.0 m.\n"
    (call,) = constrained.calls
    told = {key: call[key] for key in ("action", "prompt", "style", "guidance", "best_of")}
    assert told == {"action": None, "prompt": "a person walks far", "style": "old", "guidance": 3.0, "best_of": 2}
    given = call["constraints"]
    assert [(keep.at, len(keep.motion)) for keep in given.kept] == [(0, 20), (50, 1)]
    np.testing.assert_allclose(given.kept[1].motion.positions[0], sway(frames=60).positions[30], atol=1e-5)
    assert given.path.points.tolist() == [[0, 0], [0, 2], [3, 6]]
    assert given.loop
    again = run("generate", "-s", "used.json", "-o", "again.npz")
    assert again[0] == 0
    assert constrained.calls[1]["constraints"].kept[1].motion.rotations.tolist() == (
        given.kept[1].motion.rotations.tolist()
    ), "bit for bit"
    first, second = (engines.read(tmp_path / name) for name in ("a-person-walks-far-seed7-1.npz", "again.npz"))
    np.testing.assert_array_equal(first.rotations, second.rotations)


def test_a_whole_file_is_the_beginning_unless_told(run, constrained, tmp_path):
    sway(frames=80, fps=40.0).write(tmp_path / "odd:7.npz")
    assert run("generate", "walk", "--begin-with", "odd:7.npz", "-n", "1")[0] == 0
    assert [len(keep.motion) for keep in constrained.calls[0]["constraints"].kept] == [40], "at 20 frames a second"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--path", "0,0"], "two or more points"),
        (["--path", "0,0 0.1,0"], "length of the path is '0.10 m'; accepted: 0.3 m or more"),
        (["--path", "0,0 x"], "point of the path is 'x'"),
        (["--begin-with", "none.bvh"], "--begin-with none.bvh: there is no file none.bvh"),
        (["--begin-with", "walk.npz:0"], "--begin-with walk.npz: frames is 0; accepted: 1 to 60"),
        (["--begin-with", "walk.npz:60"], "all 60 frames are kept; make the motion longer"),
        (["--pose", "walk.npz:3"], "--pose is 'walk.npz:3'; accepted: FILE:FRAME@FRAME"),
        (["--pose", "walk.npz:60@3"], "--pose walk.npz: frame is 60; accepted: 0 to 59"),
        (["--pose", "walk.npz:6@60"], "lies behind the end of the motion at 3.0 s"),
        (["--guidance", "11"], "guidance is 11"),
        (["--best-of", "0"], "best_of is 0; accepted: 1 to 16"),
    ],
)
def test_a_mistaken_pin_is_one_line(run, constrained, tmp_path, arguments, says):
    sway(frames=60).write(tmp_path / "walk.npz")
    code, out, err = run("generate", "walk", *arguments)
    assert (code, out) == (1, "")
    assert err.startswith("error: ")
    assert says in err
    assert err.count("\n") == 1


def test_an_engine_that_takes_no_pins_says_so(run, engine):
    assert run("generate", "walk", "--loop") == (
        1, "", "error: fake takes no pins (poses, frames, a path, joints, a loop); "
        "`motionloom info fake` shows what it can do.\n",
    )  # fmt: skip


def test_list_actions_by_group(run, engine):
    code, out, _ = run("generate", "--list-actions")
    assert code == 0
    assert out.startswith("locomotion\n  walk ")
    assert "A person waves with the left hand." in out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["generate", "wlak"], "unknown action 'wlak'; did you mean 'walk'"),
        (["generate", "walk", "-f", "mp5"], "unknown export format 'mp5'; did you mean 'mp4'"),
        (["generate", "walk", "--frames", "1"], "frames is 1; accepted: 2 to 12,000"),
        (["generate", "walk", "-n", "4", "-o", "x.bvh"], "a folder for 4 motions, or --take"),
        (["generate", "walk", "-o", "x.docx"], "a file ending in .mp4"),
        (["generate", "walk", "--bone-scale", "left_knee"], "JOINT=FACTOR"),
        (["generate", "-s", "none.json"], "none.json: cannot be read"),
        (["render", "none.bvh"], "none.bvh"),
        (["render", "a.bvh", "-o", "a.avi"], "a file ending in .mp4 or .gif"),
        (["convert", "none.bvh", "a.npz"], "none.bvh"),
        (["convert", "none.bvh", "a.npz", "--retarget", "smpl23"], "did you mean 'smpl22'"),
        (["convert", "none.bvh", "a.npz", "--fps", "0"], "--fps is 0"),
        (["info", "none.bvh"], "none.bvh"),
        (["info", "action3motion"], "did you mean 'action2motion'"),
    ],
)
def test_a_persons_mistake_is_one_line_and_code_1(run, engine, arguments, says):
    code, out, err = run(*arguments)
    assert (code, out) == (1, "")
    assert err.startswith("error: ")
    assert says in err
    assert err.count("\n") == 1
    assert "Traceback" not in err


def test_cancelled_is_code_130(run, engine, monkeypatch):
    def stopped(*_args):
        raise Cancelled("generating was cancelled")

    monkeypatch.setattr(tasks, "generate", stopped)
    assert run("generate", "walk") == (130, "", "cancelled: generating was cancelled\n")


def test_ctrl_c_is_code_130(run, engine, monkeypatch):
    def interrupted(*_args):
        raise KeyboardInterrupt

    monkeypatch.setattr(tasks, "generate", interrupted)
    assert run("generate", "walk")[0] == 130


def test_convert_resamples_and_changes_the_format(run, tmp_path):
    sway(frames=40).write(tmp_path / "walk.bvh")
    assert run("convert", "walk.bvh", "sub/walk.npz", "--fps", "10") == (0, "sub/walk.npz\n", "")
    motion = engines.read(tmp_path / "sub" / "walk.npz")
    assert (motion.fps, motion.frames) == (10.0, 20)
    assert run("convert", "walk.bvh", "house.npz", "--retarget", "smpl22")[0] == 0
    assert engines.read(tmp_path / "house.npz").skeleton == engines.SMPL22


def test_convert_reads_videos(run, tmp_path, monkeypatch):
    from engines.character import video

    told = []
    monkeypatch.setattr(video, "read", lambda path, progress: told.append(path.name) or sway(frames=40))
    assert run("convert", "telephone.MOV", "walk.bvh") == (0, "walk.bvh\n", "")
    assert told == ["telephone.MOV"]
    assert len(engines.read(tmp_path / "walk.bvh")) == 40


def test_info_of_a_file_tells_length_origin_and_quality(run, engine, tmp_path):
    sway("run", frames=40, seed=4).write(tmp_path / "run.npz")
    code, out, _ = run("info", "run.npz")
    assert code == 0
    for part in ("smpl22, 22 joints", "40 frames at 20 a second, 2.00 s", "run", "fake, seed 4", "foot skate", "cm/s"):
        assert part in out


def test_info_of_an_engine(run, engine):
    code, out, _ = run("info", "action2motion")
    assert code == 0
    for part in ("variants", "walk", "CC0", engine.weights_hash):
        assert part in out
    assert "action2motion" in run("info")[1]
    assert "styles" not in out


@pytest.mark.parametrize(
    ("arguments", "told", "made"),
    [
        (["--prompt", "a person sits down"], None, 40),
        (["--prompt", "a person sits down", "--frames", "25"], 25, 25),
        (["jump"], 60, 60),
        (["jump", "--settings", "open.json"], None, 30),
    ],
)
def test_a_prompt_takes_as_long_as_it_takes(run, constrained, arguments, told, made):
    Path("open.json").write_text('{"generate": {"frames": null}}')
    code, _, err = run("generate", *arguments, "-n", "1", "-o", "it.npz", "--save-settings", "used.json")
    assert (code, err, constrained.calls[-1]["frames"]) == (0, "", told)
    assert len(engines.read("it.npz")) == made
    assert read_settings("used.json").generate.frames == told


def test_info_lists_styles_and_capabilities(run, constrained):
    out = run("info", "action2motion")[1]
    assert "3: happy, old, tired" in out
    assert "actions, best_of, constraints, guidance, lengths, scale_bones, styles, text" in out


def test_info_of_a_file_tells_what_was_not_met(run, constrained, tmp_path):
    run("generate", "walk", "--path", "0,0 0,9", "-n", "1", "-o", "far.npz")
    assert "not met" in run("info", "far.npz")[1]


def test_the_command_line_starts_without_torch_and_panel():
    script = (
        "import sys, studio.cli; "
        "print([m for m in ('torch', 'panel', 'bokeh', 'moderngl', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.strip() == "[]"


def test_convert_to_glb_with_a_body_and_without(run, tmp_path):
    sway(frames=12).write(tmp_path / "walk.bvh")
    assert run("convert", "walk.bvh", "body.glb") == (0, "body.glb\n", "")
    assert run("convert", "walk.bvh", "bones.glb", "--bones") == (0, "bones.glb\n", "")
    body, bones = engines.read(tmp_path / "body.glb"), engines.read(tmp_path / "bones.glb")
    np.testing.assert_allclose(body.positions, bones.positions, atol=1e-5)
    meshes = [b'"meshes"' in (tmp_path / name).read_bytes() for name in ("body.glb", "bones.glb")]
    assert meshes == [True, False]


def test_every_export_format_writes_its_own_kind_of_file(tmp_path):
    starts = {
        "mp4": b"ftyp", "gif": b"GIF8", "webm": b"\x1a\x45\xdf\xa3", "png": b"\x89PNG", "bvh": b"HIERARCHY",
        "glb": b"glTF", "csv": b"frame,time_s", "npz": b"PK", "amass": b"PK",
    }  # fmt: skip
    assert set(starts) == set(FORMATS)
    for kind, start in starts.items():
        how = ExportSettings((kind,), 64, 64) if kind in VIDEO_FORMATS else ExportSettings((kind,))
        path = tasks.export(sway(frames=3), tmp_path / f"walk{ending(kind)}", how)
        assert start in path.read_bytes()[:16]
    assert len(list(tmp_path.iterdir())) == len(FORMATS)


def test_an_export_cancelled_in_time_leaves_nothing(tmp_path):
    with pytest.raises(Cancelled):
        tasks.export(sway(frames=3), tmp_path / "walk.glb", ExportSettings(("glb",)), cancel=lambda: True)
    assert not list(tmp_path.iterdir())


def test_render_into_a_folder_of_pictures(run, tmp_path):
    sway(frames=3).write(tmp_path / "walk.bvh")
    options = ("--width", "64", "--height", "64", "--fps", "20")
    assert run("render", "walk.bvh", "-o", "frames", *options)[:2] == (0, "frames\n")
    names = [path.name for path in sorted((tmp_path / "frames").iterdir())]
    assert names == ["frame-00001.png", "frame-00002.png", "frame-00003.png"]
    code, _, err = run("render", "walk.bvh", "-o", "frames", *options)
    assert code == 1 and "frames: is already there" in err
