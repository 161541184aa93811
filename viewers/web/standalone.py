"""A player in one HTML file: bundle and motions inside, no server, no network."""

from __future__ import annotations

import base64
import html
import json
import os
import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from viewers import bodies
from viewers.bodies.body import Body
from viewers.web.controls import BUNDLE, Motions, actors_of, check_option, encode

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>html, body {{ margin: 0; height: 100%; background: {background}; --motion-player-radius: 0; }}
#player {{ height: 100%; }}
h1 {{ position: absolute; clip-path: inset(50%); margin: 0; }}</style>
</head>
<body>
<main id="player"><h1>{title}</h1></main>
<script type="application/json" id="values">{values}</script>
<script type="text/plain" id="bundle">{bundle}</script>
<script type="module">
const source = new Blob([document.getElementById("bundle").textContent], {{ type: "text/javascript" }});
const {{ mount }} = await import(URL.createObjectURL(source));
const values = JSON.parse(document.getElementById("values").textContent);
window.motionPlayer = mount(document.getElementById("player"), values);
</script>
</body>
</html>
"""


def page(
    motions: Motions,
    body: str | Body | None = bodies.DEFAULT,
    labels: Sequence[str] | None = None,
    title: str = "Motion",
    **options: Any,
) -> str:
    """The HTML text of a page with a player in it that fills the window.

    Args:
        motions: one, or up to 16.
        body: name of a body, a body, or None for skeletons only.
        labels: a name for each motion.
        title: of the page.
        options: any of `Controls`, e.g. `ghosts=8, trail=True, camera="front"`.

    Raises:
        UnknownLabelError: an option that does not exist.
        OutOfRangeError: an option's value that is not accepted.
    """
    body_data, take_data = encode(actors_of(motions, labels), body)
    values = {
        **{name: check_option(name, value) for name, value in options.items()},
        "body_data": base64.b64encode(body_data).decode(),
        "take_data": base64.b64encode(take_data).decode(),
    }
    return _PAGE.format(
        title=html.escape(title),
        background="#f7f8fb" if options.get("theme") == "light" else "#14171c",
        values=json.dumps(values).replace("<", "\\u003c"),
        bundle=_inert(BUNDLE.read_text(encoding="utf-8")),
    )


@dataclass(frozen=True)
class Framed:
    """A page inside a notebook's output: shows itself in JupyterLab, in nbconvert's HTML and anywhere offline."""

    text: str
    """HTML of the page, as `page` makes it."""
    height: int = 480
    """Pixels."""

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.text)}" title="Motion player" allowfullscreen '
            f'style="width: 100%; height: {self.height}px; border: 0; border-radius: 10px"></iframe>'
        )


def save_html(motions: Motions, path: str | Path, **arguments: Any) -> Path:
    """Writes a page that plays the motions by itself, for mail, the web or an archive; arguments as of `page`.

    Returns:
        The path. The file appears whole or not at all.
    """
    path = Path(path)
    text = page(motions, **arguments)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    finally:
        Path(temporary).unlink(missing_ok=True)
    return path


def _inert(script: str) -> str:
    """JavaScript that cannot end the element it stands in; both sequences occur in strings only, where `\\` is idle."""
    return re.sub(r"<(?=/script|!--)", r"<\\", script, flags=re.IGNORECASE)
