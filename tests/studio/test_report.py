"""The report of an evaluation: files, what the page holds, charts whose marks lie where the numbers say."""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from engines.evaluation import Results, TextBench, evaluate, texts
from studio.report import actions, charts, maps, write
from tests.engines.action2motion import tiny
from tests.engines.evaluation import small, test_styles, test_texts

SVG = re.compile(r"<svg.*?</svg>", re.DOTALL)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A page about two engines that differ in their decoder."""
    folder = tmp_path_factory.mktemp("report")
    engines = {"action2motion:glmi-m": tiny.engine(), "action2motion:lie": tiny.engine("lie")}
    bench = small.bench(engines)
    results = Results(bench.basis("0" * 64), bench.recogniser.labels)
    evaluate(bench, engines, results, repeats=2)
    facts = {"command": "motionloom evaluate <this> --out report/"}
    path = write.write_report(folder, bench, engines, results, 2, facts)
    return path, path.read_text(encoding="utf-8"), results


def test_files_are_written(report) -> None:
    path = report[0]
    assert {p.name for p in path.parent.iterdir()} == {"index.html", "table.md", "table.csv", "table.json"}
    values = json.loads((path.parent / "table.json").read_text())
    assert [row["row"] for row in values["rows"]][2:] == ["action2motion:glmi-m", "action2motion:lie"]
    assert path.stat().st_size < 5e6


def test_the_page_holds_everything_and_fetches_nothing(report) -> None:
    _, page, results = report
    shown = page[: page.index('<script type="application/json"')]
    assert "[[" not in page
    assert not re.search(r'(src|href)="(?!#)', page)
    assert "https:" not in shown
    fid = results.rows["action2motion:lie"].estimates["fid"]
    assert f"{fid.mean:.3f} <small>± {fid.half_width:.3f}" in shown
    assert shown.count('class="best"') >= 4
    assert "on other data and with other evaluators" in shown
    assert "&lt;this&gt;" in shown
    assert "Left out, without a held-out clip: throw." in shown
    assert all(f">{action}" in shown for action in results.actions)
    assert results.rows["action2motion:lie"].weights in shown


def test_charts_are_well_formed_and_named(report) -> None:
    found = SVG.findall(report[1])
    assert len(found) == 2 + 3 + 2 * 2 if maps.can_neighbours() else 2 + 3 + 2
    for text in found:
        root = ElementTree.fromstring(text)
        assert root.attrib["role"] == "img"
        assert root[0].tag == "title"
        assert root[0].text


def test_players_hold_a_real_motion_and_one_of_each_engine(report) -> None:
    from viewers.web.payload import unpack

    text = re.search(r'id="values">(.*?)</script>', report[1], re.DOTALL)
    assert text
    values = json.loads(text[1])
    assert len(values["takes"]) == 5
    header, _ = unpack(write.base64.b64decode(values["takes"][0]))
    assert [actor["name"] for actor in header["actors"]] == ["real", "glmi-m, 1", "glmi-m, 2", "lie, 1", "lie, 2"]


def test_examples_are_the_best_some_in_the_middle_and_the_worst() -> None:
    from tests.engines.evaluation.test_tables import row

    accuracy = np.linspace(0.0, 1.0, 11)[[3, 0, 7, 10, 1, 5, 2, 9, 4, 6, 8]]
    made = row("a", "made", 1.0, 1.0)
    for each in made.repeats:
        each.accuracy[:] = accuracy.tolist()
    chosen = actions.examples([made], [str(i) for i in range(11)])
    assert [round(10 * float(accuracy[i])) for i, _ in chosen] == [10, 9, 6, 5, 1, 0]
    assert [why for _, why in chosen] == ["best", "best", "middling", "middling", "worst", "worst"]


@pytest.mark.parametrize("log", [False, True])
def test_dots_lie_in_the_order_of_their_values(log) -> None:
    values = np.array([0.5, 40.0, 3.0])
    root = ElementTree.fromstring(charts.dots("t", ["a", "b", "c & d"], {"one": values}, log=log))
    space = "{http://www.w3.org/2000/svg}" if root.tag.startswith("{") else ""
    circles = root.findall(f"{space}circle")
    places = np.array([float(circle.attrib["cx"]) for circle in circles])
    expected = np.log(values) if log else values
    share = (places - places.min()) / np.ptp(places)
    np.testing.assert_allclose(share, (expected - expected.min()) / np.ptp(expected), atol=1e-3)
    assert [circle[0].text for circle in circles] == ["a, one: 0.5", "b, one: 40", "c & d, one: 3"]
    width = float(root.attrib["width"])
    assert all(charts.NAMES < place < width for place in places)


@pytest.mark.parametrize("values", [[0.0, 0.0], [5.0, 5.0], [1e-9, 1e3]])
def test_dots_of_odd_values(values) -> None:
    for log in (False, True):
        text = charts.dots("t", ["a", "b"], {"one": np.array(values)}, log=log)
        assert "nan" not in text
        assert "inf" not in text


def test_confusion_shows_what_there_is() -> None:
    shares = np.array([[0.75, 0.0, 0.25], [0.004, 0.996, 0.0]])
    root = ElementTree.fromstring(charts.confusion("t", ["walk", "run"], shares))
    hints = [rect[0].text for rect in root.findall("rect") if len(rect)]
    assert hints == ["walk recognised: 75 %", "walk taken for any other: 25 %", "run recognised: 100 %"]


def test_principal_components() -> None:
    rng = np.random.default_rng(0)
    line = rng.normal(size=(50, 1)) * np.array([[3.0, 4.0, 0.0]]) + 7
    points, share = maps.principal(line)
    assert share == pytest.approx(1.0)
    distances = np.abs(points[:, None, 0] - points[None, :, 0])
    np.testing.assert_allclose(distances, np.linalg.norm(line[:, None] - line[None], axis=-1), atol=1e-9)


def test_neighbours_keep_groups_together() -> None:
    pytest.importorskip("sklearn")
    rng = np.random.default_rng(0)
    groups = np.concatenate([rng.normal(size=(20, 8)), 30 + rng.normal(size=(20, 8))])
    points = maps.neighbours(groups)
    np.testing.assert_array_equal(points, maps.neighbours(groups))
    within = np.linalg.norm(points[:20] - points[:20].mean(0), axis=1).max()
    assert np.linalg.norm(points[:20].mean(0) - points[20:].mean(0)) > within


def test_a_page_about_sentences(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(texts, "captions", test_texts.captions)
    engines = {"loom": test_texts.Memory()}
    bench = TextBench(engines, test_texts.KNOWN, test_texts.Judge(), test_texts.OPTIONS)
    results = Results(bench.basis("0" * 64), ())
    evaluate(bench, engines, results, repeats=2)
    path = write.write_report(tmp_path, bench, engines, results, 2, {"command": "motionloom evaluate loom"})
    found = path.read_text(encoding="utf-8")
    assert "[[" not in found
    shown = found[: found.index('<script type="application/json"')]
    sentences = [prompt.sentence for prompt in bench.prompts(0)]
    assert all(f">{sentence}</button>" in shown for sentence in sentences[:6])
    assert sentences[6] not in re.sub(r"<svg.*?</svg>", "", shown, flags=re.DOTALL)
    assert "R-precision top 1&nbsp;↑" in shown and "By action" not in shown and "Confusion" not in shown
    assert "Guo" not in shown and ">TM2T</th>" in shown
    assert json.loads(re.findall(r'id="values">(.*?)</script>', found, re.DOTALL)[0])["takes"]
    assert len(SVG.findall(found)) == 2 if maps.can_neighbours() else 1


def test_a_page_about_manners(tmp_path) -> None:
    engine = test_styles.Engine()
    bench = test_styles.bench(engine)
    results = Results(bench.basis("0" * 64), ())
    evaluate(bench, {"says": engine}, results, repeats=2)
    page = write.write_report(tmp_path, bench, {"says": engine}, results, 2, {}).read_text(encoding="utf-8")
    shown = page[: page.index('<script type="application/json"')]
    wish = bench.wishes(0)[0]
    assert f">{bench.contents[wish.content].action} → {wish.style}<" in shown
    assert "thesis, table 5.2" in shown
    assert "Left out, without a held-out clip: tired." in shown
    assert shown.count("<h2>") == 5
