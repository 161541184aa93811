"""The notebook widget: its state is all the browser needs, and the bundle works on a model with Jupyter's manners."""

from __future__ import annotations

import base64
import io
import json
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from tests.viewers.web.conftest import PATIENCE, SIZE
from tests.viewers.web.synthetic import walk
from viewers import strips
from viewers.gl.context import NoGraphicsError
from viewers.web.controls import BUNDLE, OPTIONS
from viewers.web.player import MotionPlayer

# Backbone's manners: set() calls back at once, Python answers every saved value with an echo, bytes are DataViews.
PAGE = """<!doctype html><title>t</title><link rel="icon" href="data:,"><div id="cell"></div>
<script type="module">
const source = new Blob([document.getElementById("bundle").textContent], { type: "text/javascript" });
const { default: widget } = await import(URL.createObjectURL(source));
const view = (text) => {
  const bytes = Uint8Array.from("...." + atob(text), (letter) => letter.charCodeAt(0));
  return new DataView(bytes.buffer, 4); // messages put buffers at odd places
};
class Model {
  constructor(values) { Object.assign(this, { values, heard: {}, unsaved: {}, saved: [] }); }
  get(name) { return this.values[name]; }
  change(name, value) {
    if (this.values[name] === value) return;
    this.values[name] = value;
    for (const callback of this.heard["change:" + name] ?? []) callback();
  }
  set(name, value) { this.unsaved[name] = value; this.change(name, value); }
  save_changes() {
    for (const [name, value] of Object.entries(this.unsaved)) {
      this.saved.push([name, value]);
      setTimeout(() => { for (const callback of this.heard["change:" + name] ?? []) callback(); }, 60);
    }
    this.unsaved = {};
  }
  on(event, callback) { (this.heard[event] ??= []).push(callback); }
  off(event, callback) { this.heard[event] = this.heard[event].filter((other) => other !== callback); }
}
const values = JSON.parse(document.getElementById("values").textContent);
values.body_data = view(values.body_data);
values.take_data = view(values.take_data);
window.model = new Model(values);
window.takeDown = await widget.render({ model, el: document.getElementById("cell") });
</script>
<script type="application/json" id="values">VALUES</script>
<script type="text/plain" id="bundle">BUNDLE</script>
"""


def state_of(player: Any) -> dict[str, Any]:
    state = {name: value for name, value in player.get_state().items() if name in OPTIONS or name == "height"}
    encoded = {name: base64.b64encode(value).decode() for name, value in state.items() if isinstance(value, bytes)}
    return {**state, **encoded}


def test_state_holds_everything():
    player = MotionPlayer(walk(1.0), body="stick", height=300, ghosts=4)
    state = player.get_state()
    assert set(OPTIONS) <= set(state)
    assert (state["height"], state["ghosts"]) == (300, 4)
    assert state["_esm"] == BUNDLE.read_text(encoding="utf-8")
    player.set_state({"frame": 12, "selected": 0, "playing": True})
    assert (player.frame, player.playing) == (12, True)


def test_readers_without_widgets_see_poses(monkeypatch: pytest.MonkeyPatch):
    player = MotionPlayer([walk(1.0), walk(2.0)], body="stick", selected=1)
    data, _ = player._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in data
    assert data["text/plain"] == "<MotionPlayer of 2 motions>"
    image = Image.open(io.BytesIO(base64.b64decode(data["image/png"])))
    assert image.width > 5 * image.height

    def dark(*_args: Any, **_options: Any) -> None:
        raise NoGraphicsError("no OpenGL here")

    monkeypatch.setattr(strips, "strip", dark)
    assert "image/png" not in player._repr_mimebundle_()[0]


@pytest.mark.ui
@pytest.mark.timeout(240)
def test_in_a_cell(chromium: Any, tmp_path: Path):
    player = MotionPlayer(walk(3.0), body="stick", height=400, frame=10)
    text = PAGE.replace("VALUES", json.dumps(state_of(player))).replace("BUNDLE", BUNDLE.read_text(encoding="utf-8"))
    path = tmp_path / "cell.html"
    path.write_text(text, encoding="utf-8")
    page, complaints = chromium.new_page(viewport=SIZE), []
    page.set_default_timeout(PATIENCE)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    page.goto(path.as_uri())
    page.wait_for_function("() => window.model?.get('ready')")
    frame = "document.querySelector('.motion-player').player.frame"
    assert page.evaluate(frame) == 10
    assert page.evaluate("document.querySelector('.motion-player').clientHeight") == 400

    page.evaluate("model.change('frame', 25)")
    assert page.evaluate(frame) == 25
    page.evaluate("model.saved.length = 0")
    page.locator(".motion-player .view").focus()
    page.keyboard.press("ArrowRight")
    assert page.evaluate("model.saved") == [["frame", 26]]
    page.wait_for_timeout(200)  # the echo comes and changes nothing
    assert page.evaluate("[model.saved.length, " + frame + "]") == [1, 26]

    page.evaluate("model.change('height', 300)")
    assert page.evaluate("document.querySelector('.motion-player').clientHeight") == 300
    page.evaluate("model.change('playing', true)")
    page.wait_for_function(f"() => {frame} > 32")
    assert page.evaluate("takeDown(), document.querySelector('#cell').children.length") == 0
    assert page.evaluate("Object.values(model.heard).flat().length") == 0
    page.close()
    assert complaints == []
