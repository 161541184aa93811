from __future__ import annotations

import re
from pathlib import Path

import typer

from studio import cli
from studio.library import open_library
from studio.takes import TakeList


def test_info_names_the_place_and_the_projects(run, library, file, draw):
    draw(TakeList(library.shelf(library.create("Morning scene"))), 3)
    code, out, _err = run("library", "info", "--library", str(file))
    assert code == 0
    assert out.splitlines()[0] == str(file)
    assert "Morning scene" in out
    assert "3 takes · just now" in out


def test_a_copy_is_a_library_and_is_made_while_one_works(run, library, file, tmp_path, draw):
    key = library.create("Scene")
    takes = TakeList(library.shelf(key))
    draw(takes, 2)
    code, out, _err = run("library", "copy", str(tmp_path / "copy.db"), "--library", str(file))
    assert (code, out.strip()) == (0, str(tmp_path / "copy.db"))
    takes.remove("take-1")
    copied = open_library(str(tmp_path / "copy.db"))
    assert [take.motion.frames for take in copied.shelf(key).read()] == [8, 8]
    copied.close()
    code, _out, err = run("library", "copy", str(tmp_path / "copy.db"), "--library", str(file))
    assert (code, "is there already" in err) == (1, True)
    code, _out, err = run("library", "copy", str(tmp_path / "no" / "copy.db"), "--library", str(file))
    assert (code, "there is no such folder" in err) == (1, True)


def test_a_library_that_is_none_is_said(run, tmp_path):
    (tmp_path / "notes.db").write_text("notes " * 1000)
    code, _out, err = run("library", "info", "--library", str(tmp_path / "notes.db"))
    assert code == 1
    assert err.strip() == (
        f"error: Library {tmp_path / 'notes.db'}: this file is no library; choose another with --library."
    )


def test_the_page_on_libraries_says_what_works(library, file, draw, tmp_path, monkeypatch):
    page = (Path(__file__).resolve().parents[3] / "docs" / "library.md").read_text(encoding="utf-8")
    block = re.search(r"```python\n(.*?)```", page, re.DOTALL)
    takes = TakeList(library.shelf(library.create("Scene")))
    draw(takes, 2)
    takes.mark("take-2", tags=("good",), favourite=True)
    monkeypatch.setenv("MOTIONLOOM_LIBRARY", str(file))
    monkeypatch.chdir(tmp_path)
    exec(compile(block[1], "library.md", "exec"), {})
    assert [path.name for path in tmp_path.glob("*.bvh")] == ["Scene-take-2.bvh"]
    listed = {option.name for option in typer.main.get_command(cli.app).commands["library"].commands.values()}
    assert set(re.findall(r"motionloom library (\w+)", page)) <= listed
