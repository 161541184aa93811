"""Every notebook runs from its first to its last cell."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import nbformat
import pytest
from jupyter_client.kernelspec import KernelSpec
from nbclient import NotebookClient

import engines
from engines import registry

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))


SHARED = {"tm2t": "text", "text2motion": "text"}
"""Engine -> the notebook that it shares with another."""


@pytest.fixture
def here(monkeypatch):
    """Jupyter's `python3` kernel is the Python that runs the tests, with this checkout on its path."""
    command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    spec = KernelSpec(argv=command, display_name="tests", language="python", env={"PYTHONPATH": str(ROOT)})
    monkeypatch.setattr("jupyter_client.kernelspec.KernelSpecManager.get_kernel_spec", lambda *_args: spec)


@pytest.mark.timeout(300)
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, here, tmp_path):
    if path.stem == "text" and not registry.captioners():
        pytest.skip("no engine that describes motions has weights here")
    notebook = nbformat.read(path, as_version=4)
    where = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, timeout=240, kernel_name="python3", resources=where).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert not [output for output in outputs if output.output_type == "error"]
    widgets = [o for o in outputs if "application/vnd.jupyter.widget-view+json" in o.get("data", {})]
    pictures = [o for o in outputs if {"image/gif", "image/png"} & set(o.get("data", {}))]
    assert widgets
    assert pictures


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_kept_without_outputs(path):
    """Outputs hold whole motions; they are made by running it."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert not [cell for cell in cells if cell.get("outputs") or cell.get("execution_count")]


def test_every_engine_has_one():
    names = {path.stem for path in NOTEBOOKS}
    assert {"quickstart", *(SHARED.get(name, name) for name in engines.available())} <= names
