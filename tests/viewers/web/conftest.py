"""A Chromium with software WebGL, and pages with a player on them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from viewers.web.player import save_html

SIZE = {"width": 800, "height": 540}
PATIENCE = 90_000
"""Milliseconds: drawing on the processor of a busy machine takes its time."""


@dataclass
class PlayerPage:
    """A page with one player, and shorthands for what the tests ask of it."""

    page: Any
    complaints: list[str] = field(default_factory=list)
    path: Path | None = None

    def js(self, expression: str, argument: Any = None) -> Any:
        """Evaluates with `player`, `model` and `root` (the player's shadow root) in scope."""
        scope = (
            "const host = document.querySelector('.motion-player'), player = host.player, root = host.shadowRoot, "
            "model = window.motionPlayer?.model;"
        )
        return self.page.evaluate(f"(argument) => {{ {scope} return ({expression}); }}", argument)

    def get(self, trait: str) -> Any:
        return self.js("model.get(argument)", trait)

    def set(self, trait: str, value: Any) -> None:
        self.js("model.set(argument[0], argument[1])", [trait, value])

    def pictures(self, count: int = 2) -> None:
        """Waits until so many more pictures are drawn."""
        self.page.evaluate(
            "(count) => new Promise((done) => { const s = document.querySelector('.motion-player').player.stage; "
            "const end = s.pictures + count; const look = () => s.pictures >= end ? done() : (s.invalidate(), "
            "requestAnimationFrame(look)); look(); })",
            count,
        )

    def still(self) -> None:
        """Waits until nothing moves any more and the last picture is a fine one."""
        self.page.wait_for_function(
            """() => {
                const { stage } = document.querySelector('.motion-player').player, before = window.lastPictures;
                window.lastPictures = stage.pictures;
                return before === stage.pictures && !stage.request && !stage.rest;
            }""",
            polling=150,
        )

    def focus(self) -> None:
        self.js("root.querySelector('.view').focus()")

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    @property
    def frame(self) -> int:
        return self.js("player.frame")


@pytest.fixture
def open_player(chromium: Any, tmp_path: Path) -> Iterator[Callable[..., PlayerPage]]:
    """Opens a page with a player; a console error or an uncaught exception fails the test."""
    opened: list[PlayerPage] = []

    def start(motions: Any, *, fragment: str = "", context: dict[str, Any] | None = None, **options: Any) -> PlayerPage:
        path = save_html(motions, tmp_path / f"player{len(opened)}.html", body=options.pop("body", "stick"), **options)
        page = chromium.new_page(**{"viewport": SIZE, **(context or {})})
        page.set_default_timeout(PATIENCE)
        made = PlayerPage(page, path=path)
        page.on("pageerror", lambda error: made.complaints.append(str(error)))
        page.on("console", lambda m: made.complaints.append(m.text) if m.type in ("error", "warning") else None)
        opened.append(made)
        page.goto(f"{path.as_uri()}{fragment}")
        page.wait_for_function(
            "() => window.motionPlayer?.model.get('ready') || window.motionPlayer?.model.get('error')"
        )
        return made

    yield start
    for made in opened:
        made.page.close()
    assert [text for made in opened for text in made.complaints] == []
