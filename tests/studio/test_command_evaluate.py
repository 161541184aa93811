"""`motionloom evaluate` with engines, clips and recogniser of a few units."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from functools import partial

import pytest

import engines
from engines import datasets, weights_file
from engines.errors import UnknownLabelError
from engines.evaluation import texts
from engines.metrics.evaluators import co_embedding, recogniser
from studio import report, tasks
from tests.engines.action2motion import tiny
from tests.engines.evaluation import small, test_styles, test_texts

QUICK = ("--repeats", "2", "--motions", "10", "--frames", "8", "--out", "report")

TEXTS = ("--repeats", "2", "--motions", "64", "--out", "report")


@pytest.fixture
def run(run) -> Callable[..., tuple[int, str, str]]:
    """`run("action2motion")` is `motionloom evaluate action2motion`."""
    return partial(run, "evaluate")


def _only_tables(out, bench, named, results, repeats, _facts):
    report.write_tables(out, results, results.shown(list(named), repeats), bench.left_out)
    return out / "index.html"


@pytest.fixture
def world(monkeypatch, tmp_path):
    """Engines by variant, prepared clips and a recogniser's weights; the page itself is tested elsewhere."""
    known = {name: tiny.engine(name) for name in ("glmi-m", "lie")}
    for engine in known.values():
        engine.variants = tuple(known)

    def load(_name: str, variant: str = "glmi-m", **_options):
        if variant not in known:
            raise UnknownLabelError("variant of action2motion", variant, known)
        return known[variant]

    monkeypatch.setattr(engines, "load", load)
    monkeypatch.setattr(tasks, "load_engine", lambda *_: known["glmi-m"])
    monkeypatch.setattr(datasets, "load", lambda *_: small.clips())
    monkeypatch.setattr(recogniser, "load", lambda *_: small.recogniser())
    monkeypatch.setattr(co_embedding, "load", test_texts.Judge)
    for task in ("action", "text"):
        (tmp_path / f"evaluator-{task}.safetensors").write_bytes(b"weights")
    monkeypatch.setattr(weights_file, "SHIPPED", tmp_path)
    monkeypatch.setattr(report, "write_report", _only_tables)
    return known


def test_all_variants_in_one_table(run, world, tmp_path) -> None:
    code, out, err = run("action2motion:all", *QUICK)
    assert code == 0, err
    values = json.loads((tmp_path / "report" / "table.json").read_text())
    names = ["real (held out)", "real (training)", "action2motion:glmi-m", "action2motion:lie"]
    assert [row["row"] for row in values["rows"]] == names
    assert [row["repeats"] for row in values["rows"]] == [2] * 4
    assert all(name in out for name in names)
    assert "FID ↓" in out
    assert out.splitlines()[-1] == "report/index.html"
    assert "left out, without a held-out clip: throw" in err
    assert {p.name for p in (tmp_path / "report").iterdir()} == {"rows.json", "table.md", "table.csv", "table.json"}


def test_sentences_in_one_table(run, world, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(texts, "captions", test_texts.captions)
    monkeypatch.setattr(datasets, "load", lambda *_: test_texts.KNOWN)
    monkeypatch.setitem(world, "glmi-m", test_texts.Memory())
    code, out, err = run("action2motion", *TEXTS)
    assert code == 0, err
    values = json.loads((tmp_path / "report" / "table.json").read_text())
    assert values["basis"]["protocol"] == "text2motion"
    assert [row["row"] for row in values["rows"]] == ["real (held out)", "action2motion"]
    assert "R-precision top 1 ↑" in out
    assert "1.000 ± 0.000" in out


def test_ctrl_c_keeps_what_is_done_and_the_same_command_goes_on(run, world, tmp_path, monkeypatch) -> None:
    assert run("action2motion", "--seed", "5", *QUICK[:-1], "whole")[0] == 0
    engine, calls = world["glmi-m"], []
    make = engine.generate_many

    def interrupted(*given, **options):
        calls.append(given)
        if len(calls) == 7:  # in the second repeat of five actions
            signal.raise_signal(signal.SIGINT)
        return make(*given, **options)

    monkeypatch.setattr(engine, "generate_many", interrupted)
    before = signal.getsignal(signal.SIGINT)
    code, _, err = run("action2motion", "--seed", "5", *QUICK)
    assert code == 130
    assert err.startswith("cancelled: stopped in repeat 2 of action2motion")
    assert signal.getsignal(signal.SIGINT) is before
    assert not (tmp_path / "report" / "table.md").exists()
    code, _, err = run("action2motion", "--seed", "5", *QUICK)
    assert code == 0, err
    assert len(calls) == 7 + 5, "only the second repeat was made again"
    assert (tmp_path / "report" / "table.csv").read_text() == (tmp_path / "whole" / "table.csv").read_text()


def test_another_seed_needs_another_folder_or_fresh(run, world) -> None:
    assert run("action2motion", *QUICK)[0] == 0
    code, _, err = run("action2motion", "--seed", "1", *QUICK)
    assert code == 1
    assert "seed 0, now 1" in err
    assert run("action2motion", "--seed", "1", "--fresh", *QUICK)[0] == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["action2motoin"], "did you mean 'action2motion'"),
        (["action2motion:glmi"], "did you mean 'glmi-m'"),
        (["action2motion", "--data", "train"], "'held-out'"),
        (["action2motion", "--repeats", "0"], "--repeats is 0; accepted: 1 or more"),
        (["action2motion", "--threads", "0"], "--threads is 0"),
        (["action2motion", "--motions", "3"], "10 or more: two of each of 5 actions"),
        (["action2motion", "--frames", "1"], "4 or more"),
        (["action2motion", "--seed", "-1"], "0 to 2^63"),
        (["action2motion", "--protocol", "text"], "did you mean 'texts'"),
        (["action2motion", "--protocol", "texts", "--motions", "10"], "64 or more: pools have 32"),
    ],
)
def test_a_persons_mistake_is_one_line_and_code_1(run, world, arguments, says) -> None:
    code, out, err = run(*arguments, "--out", "report")
    assert (code, out) == (1, "")
    assert err.startswith("error: ")
    assert says in err
    assert err.count("\n") == 1


def test_engines_that_put_motions_in_other_manners(run, world, monkeypatch, tmp_path) -> None:
    engine = test_styles.Engine()
    monkeypatch.setattr(engines, "load", lambda *_a, **_k: engine)
    monkeypatch.setattr(datasets, "load", lambda *_: test_styles.KNOWN)
    shown = {
        "style": test_styles.Judge("style", ("elderly", "proud")),
        "content": test_styles.Judge("action", test_styles.ACTIONS),
    }
    monkeypatch.setattr(recogniser, "load", shown.get)
    for task in shown:
        (tmp_path / f"evaluator-{task}.safetensors").write_bytes(b"weights")
    told = ("--repeats", "2", "--motions", "4", "--out", "styles")
    code, out, err = run("action2motion", *told)
    assert (code, "Style accuracy ↑" in out) == (0, True), err
    table = (tmp_path / "styles" / "table.md").read_text(encoding="utf-8")
    assert "| 1.000 ± 0.000 |" in table
    assert "label, motion or prior" not in run("action2motion", "--by", "motion", "--fresh", *told)[2]
    assert "way to tell a style" in run("action2motion", "--by", "magic", *told)[2]


def test_missing_data_weights_and_engines_that_do_not_go_by_actions(run, world, monkeypatch, tmp_path) -> None:
    monkeypatch.setattr(world["glmi-m"], "capabilities", frozenset({"text"}))
    assert "does not go by actions" in run("action2motion", "--protocol", "actions", *QUICK)[2]
    monkeypatch.setattr(world["glmi-m"], "capabilities", frozenset({"captions"}))
    assert "no protocol fits all of them" in run("action2motion", *QUICK)[2]
    assert "takes no text" in run("action2motion", "--protocol", "texts", *TEXTS)[2]
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(recogniser, "SHIPPED", tmp_path / "nowhere")
    code, _, err = run("action2motion", *QUICK)
    assert code == 1
    assert "no such weights; train them: motionloom train evaluator --task action" in err
    monkeypatch.setattr(recogniser, "load", lambda *_: small.recogniser())
    assert "motionloom data prepare" in run("action2motion", *QUICK)[2]
    assert not (tmp_path / "report").exists()


def test_help_has_examples(run) -> None:
    code, out, _ = run("--help")
    assert code == 0
    assert "motionloom evaluate action2motion:all --out report/" in out
    assert run()[0] == 2
