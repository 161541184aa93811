"""The panel in JupyterLab, worked with the mouse; a notebook that is exported and read without kernel or network."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import nbformat
import pytest
from playwright.sync_api import Page, expect

from studio import notebook as studio_notebook
from tests.studio.fakes import ConstrainedEngine
from tests.ui.conftest import PATIENCE, ROOT, free_port, wait_for

CELLS = (
    "from studio import notebook\n"
    "from tests.studio.fakes import ConstrainedEngine\n"
    "panel = notebook.panel(ConstrainedEngine(slow=0.4), height=300, count=6)\n"
    "panel",
    "print('chosen:', panel.take.title, panel.motion.frames, 'of', len(panel.motions))\npanel.motion",
)


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[str]:
    """Address of a notebook in a JupyterLab of its own: nobody's settings, no news, no token."""
    pytest.importorskip("jupyterlab")
    work, settings = tmp_path / "work", tmp_path / "settings" / "@jupyterlab" / "apputils-extension"
    work.mkdir()
    settings.mkdir(parents=True)
    quiet = {"fetchNews": "false", "checkForUpdates": False}
    (settings / "notification.jupyterlab-settings").write_text(json.dumps(quiet), encoding="utf-8")
    cells = [nbformat.v4.new_code_cell(text) for text in CELLS]
    spec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    nbformat.write(nbformat.v4.new_notebook(cells=cells, metadata={"kernelspec": spec}), work / "waving.ipynb")
    folders = {
        "JUPYTER_CONFIG_DIR": "config", "JUPYTER_DATA_DIR": "data", "JUPYTER_RUNTIME_DIR": "runtime",
        "IPYTHONDIR": "ip", "JUPYTERLAB_SETTINGS_DIR": "settings", "JUPYTERLAB_WORKSPACES_DIR": "workspaces",
    }  # fmt: skip
    places = {name: str(tmp_path / folder) for name, folder in folders.items()} | {"PYTHONPATH": str(ROOT)}
    url = f"http://127.0.0.1:{free_port()}/"
    command = [
        sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", f"--port={url[:-1].rpartition(':')[2]}",
        "--ServerApp.ip=127.0.0.1", "--ServerApp.port_retries=0", "--IdentityProvider.token=",
        f"--ServerApp.root_dir={work}", "--LabApp.extension_manager=readonly",
    ]  # fmt: skip
    log = tmp_path / "lab.log"
    with log.open("w") as out:
        server = subprocess.Popen(command, cwd=work, stdout=out, stderr=subprocess.STDOUT, env=os.environ | places)
    try:
        wait_for(lambda: server.poll() is not None or answers(url + "api"), "JupyterLab to answer", 120)
        assert server.poll() is None, log.read_text()
        yield url + "lab/tree/waving.ipynb"
    finally:
        server.terminate()
        server.wait(30)


def answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=20) as reply:
            return reply.status == 200
    except (urllib.error.URLError, OSError):
        return False


@pytest.fixture
def page(chromium) -> Iterator[Page]:
    """A page that may ask nothing of the network and complain of nothing."""
    made = chromium.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
    made.set_default_timeout(2 * PATIENCE)
    faults: list[str] = []
    made.on("console", lambda m: faults.append(m.text) if m.type == "error" else None)
    made.on("pageerror", lambda error: faults.append(str(error)))
    ours = re.compile(r"(https?|ws)://127\.0\.0\.1:\d+/|blob:|data:|file:")
    made.on("request", lambda r: None if ours.match(r.url) else faults.append(f"asked for {r.url}"))
    yield made
    made.close()
    assert faults == []


def run(page: Page, cell: int) -> None:
    page.locator(".jp-Notebook .jp-CodeCell .jp-InputArea .cm-content").nth(cell).click()
    page.keyboard.press("Control+Enter")


@pytest.mark.timeout(420)
def test_generate_cancel_pick_and_go_on_in_the_next_cell(lab, page):
    page.goto(lab)
    run(page, 0)
    go, stop = page.get_by_role("button", name="Generate"), page.get_by_role("button", name="Cancel")
    expect(go).to_be_enabled(timeout=2 * PATIENCE)
    go.click()
    stop.click()
    expect(page.get_by_text("Cancelled: 6 × walk")).to_be_visible()
    page.get_by_label("Ways").fill("3")
    page.get_by_label("Action", exact=True).fill("wave left hand")
    page.get_by_label("Action", exact=True).press("Tab")
    expect(page.get_by_text("3 × 60 frames at 20 fps")).to_be_visible()
    go.click()
    player = page.locator(".motion-player")
    player.wait_for()
    tell = "(host) => host.player.actors.map((actor) => actor.take.name)"
    wait_for(lambda: player.evaluate(tell) == ["Take 1", "Take 2", "Take 3"], "three figures")
    page.get_by_label("Take", exact=True).select_option("Take 2 · wave left hand")
    wait_for(lambda: player.evaluate("(host) => host.player.options.selected") == 1, "the player to follow")
    page.get_by_role("button", name="Constraints").click()
    page.get_by_role("button", name="Pin this pose").click()
    expect(page.get_by_text("pose of take 2 at 0.0 s")).to_be_visible()
    run(page, 1)
    expect(page.get_by_text("chosen: Take 2 60 of 3")).to_be_visible()
    picture = page.locator(".jp-CodeCell").nth(1).locator(".jp-OutputArea img")
    expect(picture).to_be_visible()
    wide, high = picture.evaluate("(image) => [image.naturalWidth, image.naturalHeight]")
    assert wide > 5 * high, "a strip of poses"


def test_an_exported_notebook_shows_poses_and_plays(page, tmp_path):
    """As `jupyter nbconvert --to html` makes it of a notebook saved without the state of its widgets."""
    exporter = pytest.importorskip("nbconvert").HTMLExporter
    panel = studio_notebook.panel(ConstrainedEngine(), count=2, height=300)
    panel.generate().wait()
    outputs = [
        panel._repr_mimebundle_(), panel.player._repr_mimebundle_()[0], {"text/html": panel.embed()._repr_html_()},
    ]  # fmt: skip
    cells = [
        nbformat.v4.new_code_cell("panel", outputs=[nbformat.v4.new_output("execute_result", data)]) for data in outputs
    ]
    html, _ = exporter(require_js_url="", jquery_url="", mathjax_url="").from_notebook_node(
        nbformat.v4.new_notebook(cells=cells)
    )
    (tmp_path / "waving.html").write_text(html, encoding="utf-8")
    page.goto((tmp_path / "waving.html").as_uri())
    pictures = page.locator(".jp-OutputArea img")
    expect(pictures).to_have_count(2)
    assert all(pictures.nth(i).evaluate("(image) => image.naturalWidth") > 600 for i in range(2))
    player = page.frame_locator("iframe[title='Motion player']").locator(".motion-player")
    player.wait_for()
    wait_for(lambda: player.evaluate("(host) => host.player.actors.length") == 2, "both takes in the player")
