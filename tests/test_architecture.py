"""Imports go one way: studio -> viewers -> engines; and what must not need torch or a screen does not."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
ALLOWED = {"engines": {"engines"}, "viewers": {"viewers", "engines"}, "studio": {"studio", "viewers", "engines"}}


def imported(path: Path) -> set[str]:
    """Names of modules a file imports anywhere in it, absolute."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names.add(node.module or "")
    return names


@pytest.mark.parametrize("package", sorted(ALLOWED))
def test_arrows_go_one_way(package: str) -> None:
    files = list((ROOT / package).rglob("*.py"))
    assert files
    for path in files:
        ours = {name.split(".")[0] for name in imported(path)} & set(ALLOWED)
        assert ours <= ALLOWED[package], f"{path.relative_to(ROOT)} imports {sorted(ours - ALLOWED[package])}"


@pytest.mark.parametrize("folder", ["engines/geometry", "engines/formats", "engines/skeletons", "viewers"])
def test_no_torch_where_numpy_will_do(folder: str) -> None:
    # torch's own maths; kinematics serves both and imports it on demand
    only_torch = {"so3.py", "planes.py", "kinematics.py"}
    for path in (ROOT / folder).rglob("*.py"):
        if path.name not in only_torch and path.name != "bake_anny.py":
            assert not any(name.split(".")[0] == "torch" for name in imported(path)), path.relative_to(ROOT)


@pytest.mark.parametrize("module", ["engines", "engines.formats", "viewers", "studio.cli"])
def test_imports_stay_light(module: str) -> None:
    code = f"import sys, {module}; print([m for m in ('torch', 'panel', 'moderngl') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.strip() == "[]", f"importing {module} loads {done.stdout}"
