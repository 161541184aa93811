"""`motionloom data list --source` and `data describe` on a small cache of clips in one of the papers' layouts."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from engines import datasets
from engines.datasets import describe
from engines.errors import MotionloomError
from tests.engines.datasets import folders


@pytest.fixture
def prepared(run, tmp_path) -> Path:
    """HumanML3D (4 clips) and HumanAct12 (3 clips) prepared."""
    folders.humanml3d(tmp_path / "data" / "HumanML3D")
    folders.humanact12(tmp_path / "data" / "HumanAct12")
    datasets.prepare(tmp_path / "data", ["humanml3d", "humanact12"], workers=1)
    return tmp_path / "data"


def test_describe_counts_parts_labels_and_sentences(run, prepared):
    code, out, err = run("data", "describe", "humanact12", "--by", "label")
    assert (code, err) == (0, "")
    rows = {line[:30].strip(): line[30:].split() for line in out.splitlines() if line}
    assert rows["clips"][0] == "3"
    assert rows["subjects"] == ["1"]
    assert {name: rows[name][:2] for name in ("drink", "throw", "warm up")} == {
        name: ["1", "0.0"] for name in ("drink", "throw", "warm up")
    }
    code, out, _ = run("data", "describe", "humanml3d")
    rows = {line[:30].strip(): line[30:].split() for line in out.splitlines() if line}
    assert rows["clips"] == ["4", "(2", "train,", "1", "val,", "1", "test)"]
    assert rows["sentences"][0] == "4", "three of whole clips and one of a part"


def test_bars_are_as_long_as_clips_are_many(run, prepared):
    _, out, _ = run("data", "describe", "--by", "split")
    mark = "█" if "█" in out else "#"
    length = {line.split()[0]: line.count(mark) for line in out.splitlines() if line.rstrip().endswith(mark)}
    counts = {line.split()[0]: int(line.split()[1]) for line in out.splitlines() if line.rstrip().endswith(mark)}
    most = max(counts.values())
    assert length == {name: max(1, round(30 * count / most)) for name, count in counts.items()}
    assert sum(counts.values()) == 7


@pytest.mark.parametrize("suffix", ["svg", "png"])
def test_the_plot_shows_a_bar_a_label(run, prepared, tmp_path, suffix):
    code, out, _ = run("data", "describe", "humanact12", "--by", "label", "--plot", f"labels.{suffix}")
    assert code == 0
    assert out.splitlines()[-1] == f"labels.{suffix}"
    path = tmp_path / f"labels.{suffix}"
    if suffix == "svg":
        tree = ElementTree.parse(path)
        names = [node.text for node in tree.iter("{http://www.w3.org/2000/svg}text")]
        assert {"drink", "throw", "warm up"} <= set(names)
        assert len(list(tree.iter("{http://www.w3.org/2000/svg}rect"))) == 4, "the ground and three bars"
    else:
        pixels = np.asarray(Image.open(path).convert("RGB"))
        blue = (pixels == (0x3B, 0x6F, 0xD4)).all(axis=-1).any(axis=1)
        assert (np.diff(blue.astype(int)) == 1).sum() == 3, "three bars"
    assert sorted(p.name for p in tmp_path.iterdir() if p.is_file()) == [f"labels.{suffix}"]


def test_captions_are_shown(run, prepared):
    _, out, _ = run("data", "describe", "humanact12", "--captions", "2", "--seed", "1")
    assert sum(line.startswith("  ") and line.endswith(".") for line in out.splitlines()) == 12
    assert out.count("humanact12/P03") == 2


def test_list_tells_what_lies_in_a_folder_and_where_to_get_the_rest(run, prepared):
    folders.kit(prepared / "KIT-ML")
    (prepared / "cmu-mocap-subset.tar.xz").write_bytes(b"x" * 3 * 2**20)
    code, out, err = run("data", "list", "--source", "data")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    after = {
        line.split()[0]: lines[index + 1].strip() for index, line in enumerate(lines[:-1]) if line[:1] != " " and line
    }
    assert after["kit-ml"] == "found in data: 1 clips"
    assert after["cmu"] == "found in data: packed, 3 MB"
    assert after["humanml3d"] == "found in data: 4 clips"
    assert after["amass"] == f"from {datasets.CORPORA['amass'].download}"
    for name, corpus in datasets.CORPORA.items():
        assert (corpus.layout in out) == (name not in {"humanml3d", "humanact12"}), "what is there need not be got"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["describe", "humanml"], "did you mean 'humanml3d'"),
        (["describe", "--by", "stile"], "did you mean 'style'"),
        (["describe", "--captions", "-1"], "--captions is -1"),
        (["describe", "--plot", "x.pdf"], "accepted: .svg, .png"),
        (["describe", "kit-ml"], "kit-ml: there are no clips to describe"),
        (["list", "--source", "nowhere"], "is no folder"),
    ],
)
def test_a_persons_mistake_is_one_line_and_code_1(run, prepared, arguments, says):
    code, _, err = run("data", *arguments)
    assert code == 1
    assert err.startswith("error: ")
    assert says in err
    assert err.count("\n") == 1


def test_describe_without_a_cache_says_what_to_do(run):
    code, out, err = run("data", "describe")
    assert (code, out) == (1, "")
    assert "motionloom data prepare --source" in err


def test_no_clips_cannot_be_summarised():
    with pytest.raises(MotionloomError, match="no clips"):
        describe.summarise([])


def test_found_tells_damage(tmp_path):
    folders.humanml3d(tmp_path / "HumanML3D")
    (tmp_path / "HumanML3D" / "texts" / "000000.txt").write_text("no times\n")
    assert describe.found(tmp_path)["humanml3d"].startswith("damaged: ")
    assert set(describe.found(tmp_path)) == {"humanml3d"}
