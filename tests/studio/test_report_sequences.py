"""The page of MultiAct's protocol, with engines and clips of a few units."""

from __future__ import annotations

import pytest

from engines.evaluation import Results, SequenceBench, evaluate, sequences
from engines.evaluation.ways import ways
from studio import report
from tests.engines.action2motion import tiny
from tests.engines.evaluation import small
from tests.engines.evaluation.test_sequences import CLIPS, OPTIONS


def test_the_page_has_figures_examples_and_the_papers_own(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sequences, "TRIPLETS", 20)
    engines = {name: way for name, way in ways(tiny.engine()).items() if way.variant in {"slerp", "label switch"}}
    bench = SequenceBench(engines, CLIPS, small.recogniser(), OPTIONS)
    results = Results(bench.basis("e"), bench.recogniser.labels)
    evaluate(bench, engines, results, repeats=1)
    page = report.write_report(tmp_path, bench, engines, results, 1, {"command": "motionloom evaluate"})
    html = page.read_text(encoding="utf-8")
    assert "Transition FID" in html and "ACTOR + interpolation" in html and " › " in html
    assert {"table.md", "table.csv", "table.json"} <= {path.name for path in tmp_path.iterdir()}
