"""The table as text: digits, arrows, the best in bold, and what others published set apart."""

from __future__ import annotations

import csv
import io
import json

import pytest

from engines.evaluation import Repeat, Results, Row, published, tables
from engines.evaluation.rounds import REAL, TRAINING
from engines.metrics.protocol import Estimate

BASIS = {"data": "test", "motions": 300, "frames": 60, "seed": 0, "actions": ["walk", "run"]}


def row(name: str, kind, fid: float, diversity: float, jitter: float = 60.0) -> Row:
    made = [
        Repeat({"diversity": diversity + d, "fid": fid + d, "jitter": jitter}, [1.0, 0.5], [0.1, 0.2], [[0, 0, 3]], 1.0)
        for d in (-0.1, 0.1)
    ]
    return Row(name, kind, "f" * 64, {}, made)


@pytest.fixture
def rows() -> list[Row]:
    return [row(REAL, "real", 0.1, 5.0), row(TRAINING, "real", 0.5, 9.0), row("a", "made", 3.0, 8.0),
            row("b", "made", 2.0, 11.0, 123.4)]  # fmt: skip


@pytest.fixture
def results(rows) -> Results:
    return Results(BASIS, ("walk", "run", "jump"), {row.name: row for row in rows})


def test_best_of_the_generated(rows) -> None:
    assert tables.best(rows, "fid") == ("b",)
    assert tables.best(rows, "diversity") == ("a",), "nearest to real training motions, not highest"
    assert tables.best(rows[:3], "fid") == (), "nothing to choose from"


def test_a_tie_is_told_and_so_is_what_it_means(rows) -> None:
    tied = [*rows, row("c", "made", 2.0, 10.5, 123.4)]
    assert tables.best(tied, "fid") == ("b", "c")
    assert tables.same_networks(rows) == []
    (said,) = tables.same_networks(tied)
    assert said.startswith("b and c agree to all digits in jitter")


@pytest.mark.parametrize(
    ("estimate", "text"),
    [(None, "–"), (Estimate(0.12345, 0.0049), "0.123 ± 0.005"), (Estimate(12.345, 0.1), "12.35 ± 0.10"),
     (Estimate(-123.45, 2.0), "-123.5 ± 2.0")],
)  # fmt: skip
def test_cells(estimate, text) -> None:
    assert tables.cell(estimate) == text


def test_markdown(results, rows) -> None:
    text = tables.markdown(results, rows, {"without a held-out clip": ("hop", "leap")})
    lines = text.splitlines()
    assert lines[2] == "|  | FID ↓ | Diversity → | Jitter → (m/s³) |"
    assert "| b | **2.000 ± 1.271** | 11.00 ± 1.27 | 123.4 ± 0.0 |" in lines
    assert "| a | 3.000 ± 1.271 | **8.000 ± 1.271** | **60.00 ± 0.00** |" in lines
    assert "Left out, without a held-out clip: hop, leap." in text
    assert published.WARNING.capitalize() in text
    glmi = "| Action2Motion (GLMI-M) | 2.157 ± 0.052 | 0.835 ± 0.005 | 6.986 ± 0.028 | 3.633 ± 0.031 | "
    assert glmi + "HumanAct12, 12 actions | thesis, table 3.2 |" in lines
    width = {line.count("|") for line in lines[2:8] if line.startswith("|")}
    assert width == {5}


def test_comma_separated(results, rows) -> None:
    read = list(csv.DictReader(io.StringIO(tables.comma_separated(results, rows))))
    assert [r["row"] for r in read[:4]] == [REAL, TRAINING, "a", "b"]
    assert float(read[3]["fid"]) == pytest.approx(2.0)
    assert float(read[3]["fid_half_width"]) == pytest.approx(1.2706, abs=1e-3)
    assert {r["source"] for r in read[:4]} == {"measured here"}
    assert all("other data" in r["source"] for r in read[4:])
    assert len(read) == 4 + len(published.ACTION2MOTION)


def test_json(results, rows) -> None:
    values = json.loads(json.dumps(tables.as_json(results, rows, {})))
    found = values["rows"][2]
    assert found["actions"]["accuracy"] == {"walk": 1.0, "run": 0.5}
    assert found["figures"]["fid"]["repeats"] == pytest.approx([2.9, 3.1])
    assert values["metrics"]["fid"]["better"] == "lower"
    assert len(values["published, on other data"]) == 18


def test_published_tables_agree_with_the_papers_own_words() -> None:
    """GLMI-M has the best FID of the four wherever it was measured (thesis, section 3.3)."""
    for data in {row.data for row in published.ACTION2MOTION}:
        made = {r.method: r.figures["fid"].mean for r in published.ACTION2MOTION if r.data == data and "(" in r.method}
        expected = "Action2Motion (w/ Lie)" if data == "NTU-RGBD" else "Action2Motion (GLMI-M)"
        assert min(made, key=lambda name: made[name]) == expected


def test_published_text_tables_agree_with_the_papers_own_words() -> None:
    """Real lengths help nearly everywhere; Text2Motion is more exact than TM2T (their tables' marks of the best)."""
    for data in ("HumanML3D", "KIT-ML"):
        rows = {row.method: row.figures for row in published.TEXT2MOTION if row.data == data}
        assert list(rows) == ["Real motions", "Text2Motion, real length", "Text2Motion", "TM2T"]
        top = {name: figures["r_precision_top1"].mean for name, figures in rows.items()}
        assert list(top) == sorted(top, key=lambda name: -top[name])
        for figures in rows.values():
            shares = [figures[f"r_precision_top{k}"].mean for k in (1, 2, 3)]
            assert shares == sorted(shares)
        assert "multimodality" not in rows["Real motions"]
        assert set(rows["TM2T"]) == set(published.TEXT_COLUMNS)


def test_a_table_of_texts_has_its_own_columns_notes_and_papers() -> None:
    figures = {"r_precision_top1": 0.5, "fid": 0.1, "multimodal_distance": 0.9, "jitter": 50.0}
    rows = [Row(REAL, "real", "", {}, [Repeat(figures)]), Row("loom", "made", "a" * 64, {}, [Repeat(figures)])]
    basis = {"protocol": "text2motion", "data": "test", "motions": 300, "sentences with many": 10, "seed": 0}
    found = Results(basis, (), {row.name: row for row in rows})
    text = tables.markdown(found, rows, {})
    lines = text.splitlines()
    assert lines[0] == "# Text2Motion's protocol"
    assert lines[2] == "|  | R-precision top 1 ↑ | FID ↓ | Multimodal distance ↓ | Jitter → (m/s³) |"
    assert "By chance: 0.031" in text and "10 sentences, 30 motions each" in text
    assert "| Text2Motion | 0.455 ± 0.003 | 0.636 ± 0.003 | 0.736 ± 0.002 | 1.087 ± 0.021 | " in text
    assert "actions" not in tables.as_json(found, rows, {})["rows"][1]
    assert "Action2Motion" not in text
