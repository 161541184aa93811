"""Who is let in: what cannot work is said before the start, and a started studio asks."""

from __future__ import annotations

import asyncio
import http.cookiejar
import json
import os
import re
import subprocess
import sys
import urllib.error
import urllib.parse
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from engines.errors import FormatError, MotionloomError, OutOfRangeError, UnknownLabelError
from studio import downloads
from studio.serving import Access, processes
from tests.ui.conftest import ROOT, free_port, wait_for

PASSWORD = "a heap of walnuts"


@pytest.mark.parametrize(
    ("said", "problem", "words"),
    [
        ({"basic_auth": "x", "oauth_provider": "github"}, MotionloomError, "one of the two"),
        ({"oauth_provider": "gihub", "oauth_key": "k", "oauth_secret": "s"}, UnknownLabelError, "'github'"),
        ({"oauth_provider": "github", "oauth_key": "k"}, MotionloomError, "PANEL_OAUTH_SECRET"),
        ({"origins": ("https://lab.example.org",)}, OutOfRangeError, "without https://"),
        ({"basic_auth": "nowhere/people.json"}, FormatError, "there is no such file"),
    ],
)
def test_what_cannot_work_is_said_with_what_would(said, problem, words):
    with pytest.raises(problem, match=re.escape(words)):
        Access(**said).checked("127.0.0.1")


def test_whoever_asks_others_to_sign_in_says_under_which_address():
    with pytest.raises(MotionloomError, match="--allow-websocket-origin"):
        Access(basic_auth="x").checked("0.0.0.0")
    told = Access(basic_auth="x", origins=("lab.example.org:5006",)).checked("0.0.0.0").options("0.0.0.0", 5006)
    assert told["websocket_origin"] == ["lab.example.org:5006", "localhost:5006", "127.0.0.1:5006"]
    assert len(told["cookie_secret"]) >= 32


@pytest.mark.parametrize("text", ["[1]", "{}", '{"anna": 3}', "not json"])
def test_a_file_of_passwords_holds_names_and_passwords(tmp_path, text):
    file = tmp_path / "people.json"
    file.write_text(text)
    with pytest.raises(FormatError, match="names and passwords"):
        Access(basic_auth=str(file)).checked("127.0.0.1")
    file.write_text('{"anna": "walnuts"}')
    assert Access(basic_auth=str(file)).checked("127.0.0.1").asks


def test_secrets_are_not_in_what_is_logged():
    assert "walnuts" not in repr(Access(basic_auth="walnuts", oauth_secret="walnuts", cookie_secret="walnuts"))


def test_numbers_of_processes():
    assert processes(3) == 3
    assert processes(0) == os.cpu_count()
    for wrong in (-1, 65):
        with pytest.raises(OutOfRangeError, match="--num-procs"):
            processes(wrong)


def test_a_file_offered_by_one_process_is_found_by_another(tmp_path, monkeypatch):
    notes, exported = tmp_path / "notes", tmp_path / "session" / "take-1.bvh"
    for folder in (notes, exported.parent):
        folder.mkdir()
    exported.write_text("HIERARCHY")
    monkeypatch.setattr(downloads, "_shared", [notes])
    _route, key, name = downloads.offer(exported).split("/")
    with monkeypatch.context() as other:
        other.setattr(downloads, "_files", {})
        assert downloads.find(key, name) == exported
        assert downloads.find(key, "take-2.bvh") is None
    downloads.withdraw(exported.parent)
    assert downloads.find(key, name) is None
    assert list(notes.iterdir()) == []


# ---- a studio with passwords and two processes ------------------------------------------------------------


@pytest.fixture(scope="module")
def guarded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("guarded")
    (folder / "people.json").write_text(json.dumps({"anna": PASSWORD}))
    port = free_port()
    command = [sys.executable, "-m", "studio.cli", "studio", "--port", str(port), "--no-browser", "--num-procs", "2"]
    command += ["--basic-auth", str(folder / "people.json"), "--allow-websocket-origin", "lab.example.org"]
    places = {"TMPDIR": str(folder), "MOTIONLOOM_LIBRARY": str(folder / "library.db")}
    with (folder / "log").open("w") as log:
        server = subprocess.Popen(command, cwd=ROOT, stdout=log, stderr=log, env=os.environ | places)
    url = f"http://127.0.0.1:{port}/"
    try:
        wait_for(lambda: server.poll() is not None or _status(url), "the studio to answer")
        assert server.poll() is None, (folder / "log").read_text()
        children = _children(server.pid)
        yield url
    finally:
        server.terminate()
        server.wait(20)
    wait_for(lambda: not any(_alive(child) for child in children), "its processes to end")
    assert len(children) == 2
    assert not list(folder.glob("motionloom-*")), "files are left behind"
    assert "Traceback" not in (folder / "log").read_text(), (folder / "log").read_text()


def _status(url: str) -> int:
    try:
        return urllib.request.urlopen(url, timeout=20).status
    except OSError:
        return 0


def _children(process: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def _alive(process: int) -> bool:
    stat = Path(f"/proc/{process}/stat")
    return stat.exists() and stat.read_text().rsplit(")", 1)[1].split()[0] != "Z"


def sign_in(url: str, password: str) -> tuple[str, str]:
    """(page one comes to, cookies) after signing in as anna."""
    jar = http.cookiejar.CookieJar()
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(jar))
    form = urllib.parse.urlencode({"username": "anna", "password": password}).encode()
    opener.open(url + "login", timeout=20).read()
    page = opener.open(url + "login", form, timeout=60).read().decode()
    return page, "; ".join(f"{cookie.name}={cookie.value}" for cookie in jar)


def connect(url: str, page: str, **headers: str) -> int:
    """Status with which a websocket is answered; 101 where it is opened."""
    found = re.search(r'"token":\s*"([^"]+)"', page)
    token = found[1] if found else "none"

    async def go() -> int:
        request = HTTPRequest(url.replace("http", "ws", 1) + "ws", headers=headers)
        try:
            (await websocket_connect(request, subprotocols=["bokeh", token])).close()
        except HTTPClientError as refused:
            return refused.code
        return 101

    # in a thread of its own: the browser's tests may leave a loop running in this one
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(lambda: asyncio.run(go())).result()


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="looks at processes as Linux shows them")
def test_a_password_is_asked_for_and_foreign_pages_are_refused(guarded):
    asked = urllib.request.urlopen(guarded, timeout=20)
    assert asked.url.startswith(guarded + "login")
    assert "https://" not in (text := asked.read().decode())
    assert "Sign in" in text
    wrong, cookies = sign_in(guarded, "walnuts")
    assert "do not fit together" in wrong
    assert "user=" not in cookies
    page, cookies = sign_in(guarded, PASSWORD)
    assert "Opening the studio" in page
    own = {"Origin": guarded.rstrip("/"), "Cookie": cookies}
    assert connect(guarded, page, **own) == 101
    assert connect(guarded, page, **own | {"Origin": "http://lab.example.org"}) == 101
    assert connect(guarded, page, **own | {"Origin": "http://evil.example.org"}) == 403
    assert connect(guarded, page, Origin=own["Origin"]) in (401, 403)
