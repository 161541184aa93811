"""Many people at once: how long each waits for an action clip, and whether each gets his own.

    python benchmarks/load.py [--sessions 20] [--count 1] [--rounds 3] [--engine loom]

A studio runs in a process of its own. Each session is a page as the server sees one: the page is fetched, its websocket
speaks Bokeh's protocol, and what a browser sends and gets goes through it; only drawing is left out. All press Generate
at the same moment, each with another action. Measured is the time from the press to the message that brings the take's
card. A card of another's action, or one too many, ends the run with an error.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import re
import sys
import tempfile
import time
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np
from tornado.httpclient import HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.ui.conftest import free_port, start  # noqa: E402 - no package, found through the line above

PATIENCE = 300.0
"""Seconds until a session is given up."""


def plain(value: Any) -> Any:
    """A value of Bokeh's JSON without its wrapping of dicts."""
    if isinstance(value, dict):
        if value.get("type") == "map":
            return {key: plain(held) for key, held in value.get("entries", [])}
        return {key: plain(held) for key, held in value.items()}
    return [plain(held) for held in value] if isinstance(value, list) else value


def objects(value: Any) -> list[dict[str, Any]]:
    """Every model of a document's JSON."""
    if isinstance(value, list):
        return [found for held in value for found in objects(held)]
    if not isinstance(value, dict):
        return []
    own = [value] if value.get("type") == "object" else []
    return own + [found for held in value.values() for found in objects(held)]


class Session:
    """One page of the studio, without a browser."""

    def __init__(self, url: str) -> None:
        self.url = url
        self.socket: WebSocketClientConnection | None = None
        self.parts: dict[str, str] = {}
        """Name of a component -> id of what holds its values, and `NAME!` -> id of itself."""
        self.values: dict[tuple[str, str], Any] = {}
        self.changed = asyncio.Event()
        self.ready, self.pulled = asyncio.Event(), asyncio.Event()

    async def open(self) -> None:
        """Fetch the page, connect, and say that it is shown."""
        page = await asyncio.to_thread(lambda: urllib.request.urlopen(self.url, timeout=PATIENCE).read().decode())
        found = re.search(r'"token":\s*"([^"]+)"', page)
        assert found is not None, "the page holds no token"
        address = self.url.replace("http", "ws", 1) + "ws"
        origin = {"Origin": self.url.rstrip("/")}
        self.socket = await websocket_connect(
            HTTPRequest(address, headers=origin), subprotocols=["bokeh", found[1]], max_message_size=2**28
        )
        self.listening = asyncio.create_task(self._listen())
        await asyncio.wait_for(self.ready.wait(), PATIENCE)
        await self._send("PULL-DOC-REQ", {})
        await asyncio.wait_for(self.pulled.wait(), PATIENCE)
        await self._event({"type": "event", "name": "document_ready", "values": {"type": "map", "entries": []}})

    async def set(self, part: str, name: str, value: Any) -> None:
        """Set a value of a component, as its script would."""
        await self._patch({"kind": "ModelChanged", "model": {"id": self.parts[part]}, "attr": name, "new": value})

    async def press(self, part: str, do: str) -> None:
        """Send a message of a component, as its script would."""
        values = [["model", {"id": self.parts[part + "!"]}], ["data", {"type": "map", "entries": [["do", do]]}]]
        await self._event({"type": "event", "name": "data_event", "values": {"type": "map", "entries": values}})

    def get(self, part: str, name: str) -> Any:
        """A value of a component as the studio sent it last."""
        return self.values.get((self.parts[part], name))

    async def until(self, true: Any, what: str) -> None:
        """Wait until what the studio sent makes it so."""
        end = time.monotonic() + PATIENCE
        while not true():
            self.changed.clear()
            try:
                await asyncio.wait_for(self.changed.wait(), end - time.monotonic())
            except TimeoutError:
                raise SystemExit(f"waited {PATIENCE:g} s for {what}") from None

    def close(self) -> None:
        """Leave."""
        self.listening.cancel()
        if self.socket is not None:
            self.socket.close()

    # ---- Bokeh's protocol: a message is header, metadata and content, then pairs for buffers --------------------

    async def _send(self, kind: str, content: dict[str, Any]) -> None:
        assert self.socket is not None
        header = {"msgid": os.urandom(8).hex(), "msgtype": kind}
        for fragment in (header, {}, content):
            await self.socket.write_message(json.dumps(fragment))

    async def _patch(self, event: dict[str, Any]) -> None:
        await self._send("PATCH-DOC", {"events": [event]})

    async def _event(self, event: dict[str, Any]) -> None:
        await self._patch({"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": event})

    async def _read(self) -> Any:
        assert self.socket is not None
        fragment = await self.socket.read_message()
        if fragment is None:
            raise SystemExit("the studio closed a connection")
        return fragment

    async def _listen(self) -> None:
        while True:
            header = json.loads(await self._read())
            await self._read()
            content = json.loads(await self._read())
            for _ in range(2 * header.get("num_buffers", 0)):
                await self._read()
            if header["msgtype"] == "ACK":
                self.ready.set()
            elif header["msgtype"] == "PULL-DOC-REPLY":
                self._know(content["doc"]["roots"])
                self.pulled.set()
            elif header["msgtype"] == "PATCH-DOC":
                self._know(content)
                for event in content["events"]:
                    if event["kind"] == "ModelChanged":
                        self.values[event["model"]["id"], event["attr"]] = plain(event["new"])
            elif header["msgtype"] == "ERROR":
                raise SystemExit(f"the studio says: {content.get('text')}")
            self.changed.set()

    def _know(self, tree: Any) -> None:
        """Remember where components keep their values."""
        for model in objects(tree):
            own = model.get("attributes", {})
            data = own.get("data")
            if isinstance(data, dict) and data.get("type") == "object":
                name = data.get("attributes", {}).get("noun", "") + re.sub(r"\d+$", "", data["name"])
                self.parts |= {name: data["id"], name + "!": model["id"]}
                self.values |= {(data["id"], key): plain(value) for key, value in data.get("attributes", {}).items()}
            if own.get("title"):
                self.parts[own["title"]] = model["id"]


async def one(session: Session, action: str, count: int) -> float:
    """Ask for an action. Returns the seconds until its take is there."""
    before = session.get("TakeGallery", "takes")
    known = {take["id"] for take in before}
    await session.set("ActionField", "value", action)
    began = time.perf_counter()
    await session.press("Page", "generate")
    await session.until(lambda: len(session.get("TakeGallery", "takes")) >= len(known) + count, f"the take of {action}")
    seconds = time.perf_counter() - began
    new = [take["subject"] for take in session.get("TakeGallery", "takes") if take["id"] not in known]
    if new != [action] * count:
        raise SystemExit(f"cross-talk: asked for {count} × {action}, got {new}")
    return seconds


def spent(process: int) -> np.ndarray:
    """(2,) processor seconds of a process so far, and those of its first thread (Linux; 0 elsewhere)."""
    seconds = []
    for stat in (Path(f"/proc/{process}/stat"), Path(f"/proc/{process}/task/{process}/stat")):
        fields = stat.read_text().rsplit(")", 1)[1].split() if stat.exists() else ["0"] * 20
        seconds.append((int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"))
    return np.array(seconds)


async def run(url: str, asked: argparse.Namespace, process: int) -> list[tuple[list[float], np.ndarray]]:
    """All sessions through all rounds. Returns seconds a session and processor seconds, by round."""
    sessions = [Session(url) for _ in range(asked.sessions)]
    for session in sessions:  # one by one: what is measured is not the opening of pages
        await session.open()
        await session.until(lambda s=session: s.get("TakeGallery", "takes"), "the first takes")
        if asked.engine and session.get("ActionGrid", "actions") is not None and "Engine" in session.parts:
            await session.set("Engine", "value", asked.engine)
        await session.set("Variations", "value", asked.count)
    await asyncio.sleep(2.0)  # thumbnails of the first takes
    names = [entry["name"] for entry in sessions[0].get("ActionGrid", "actions")]
    rounds = []
    for turn in range(asked.rounds):
        wanted = [names[(turn + place) % len(names)] for place in range(len(sessions))]
        before = spent(process)
        waited = await asyncio.gather(*(one(s, a, asked.count) for s, a in zip(sessions, wanted, strict=True)))
        rounds.append((waited, spent(process) - before))
        await asyncio.sleep(3.0)  # thumbnails
    for session in sessions:
        session.close()
    return rounds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sessions", type=int, default=20)
    parser.add_argument("--count", type=int, default=1, help="variations each asks for")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--engine", default="", help="[the studio's usual one]")
    asked = parser.parse_args()
    folder = tempfile.TemporaryDirectory()
    url, server = start("studio.cli", Path(folder.name), free_port())
    try:
        rounds = asyncio.run(run(url, asked, server.pid))
    finally:
        server.terminate()
        server.wait(20)
        folder.cleanup()
    load = os.getloadavg()[0]
    print(f"{asked.sessions} sessions at once, {asked.count} clip(s) of 3 s each; load of the machine {load:.1f}")
    print(f"{'':10}{'p50':>8}{'p95':>8}{'longest':>9}{'processor':>12}{'of that, pages':>16}")
    for turn, (seconds, processor) in enumerate(rounds, 1):
        p50, p95 = np.percentile(seconds, [50, 95])
        print(
            f"{f'round {turn}':10}{p50:7.2f}s{p95:7.2f}s{max(seconds):8.2f}s{processor[0]:11.2f}s{processor[1]:15.2f}s"
        )
    print("every session got its own action, and nothing else")


if __name__ == "__main__":
    main()
