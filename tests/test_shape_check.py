"""The check of annotated shapes is on in this test run, and refuses what the annotations do not allow."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import typing
from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import torch
from jaxtyping import TypeCheckError

import engines.metrics.physical
import viewers.bodies.body
from engines.geometry import canonical, contacts, kinematics, mirror, planes, rotations, so3
from engines.skeletons import SMPL22
from tests.shape_check import CHECKED, REFUSE_IN_WORDS

J = len(SMPL22)
WRONG: dict[str, Callable[[], object]] = {
    "a fixed axis": lambda: rotations.quaternion_to_matrix(np.ones((5, 3))),
    "a missing axis": lambda: contacts.detect(np.zeros((J, 3)), 20.0, SMPL22),
    "an axis that two arguments share": lambda: mirror.mirror(np.ones((4, J, 4)), np.zeros((3, 3)), SMPL22),
    "axes that do not broadcast": lambda: rotations.rotate(np.ones((2, 4)), np.ones((3, 3))),
    "whole numbers": lambda: contacts.joint_speed(np.zeros((4, J, 3), dtype=int), 20.0),
    "a tensor for an array": lambda: rotations.normalise(torch.ones(5, 3)),  # pyright: ignore[reportArgumentType]
    "a tensor's axis": lambda: so3.hat(torch.zeros(2, 4)),
    "components behind instead of in front": lambda: planes.turn(torch.zeros(J, 9, 3, 3), torch.zeros(J, 9, 3)),
    "either library": lambda: kinematics.global_rotations(torch.zeros(7, J, 9), SMPL22.parents),
    "words for a number": lambda: contacts.joint_speed(np.zeros((4, J, 3)), "20"),  # pyright: ignore[reportArgumentType]
}


def modules() -> list[ModuleType]:
    """Those of `CHECKED`; of a package, the modules in it."""
    names: list[str] = []
    for name in CHECKED:
        folder = getattr(importlib.import_module(name), "__path__", None)
        names += [name] if folder is None else [f"{name}.{below.name}" for below in pkgutil.iter_modules(folder)]
    return [importlib.import_module(name) for name in names]


def layers(function: Any) -> Iterator[Any]:
    """A function and what its decorators stand around, from the outside in."""
    while function is not None:
        yield function
        function = getattr(function, "__wrapped__", None)


def functions(module: ModuleType) -> Iterator[Callable[..., object]]:
    """The module's own public functions and those of its classes, properties included."""
    for name, member in vars(module).items():
        if name.startswith("_") or getattr(member, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(member):
            yield member
        elif inspect.isclass(member):
            for key, value in vars(member).items():
                inner = (getattr(value, name, None) for name in ("fget", "func", "__func__"))  # behind a decorator
                found = next(filter(None, inner), value)
                if inspect.isfunction(found) and not key.startswith("_"):
                    yield found


@pytest.mark.parametrize("what", WRONG)
def test_wrong_arguments_are_refused(what: str) -> None:
    with pytest.raises(TypeCheckError):
        WRONG[what]()


def test_a_wrong_result_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert canonical.heading(np.zeros((5, J, 3)), SMPL22).shape == (5,)
    monkeypatch.setattr(canonical, "across", lambda positions, skeleton: np.ones((len(positions) - 1, 3)))
    with pytest.raises(TypeCheckError, match="return value"):
        canonical.heading(np.zeros((5, J, 3)), SMPL22)


@pytest.mark.parametrize("module", modules(), ids=lambda module: module.__name__)
def test_every_public_function_is_checked(module: ModuleType) -> None:
    """None was imported before the check was installed, and none has an annotation that means nothing to it."""
    found = list(functions(module))
    assert found
    for function in found:
        checked = any(layer.__globals__["__name__"] == "jaxtyping._decorator" for layer in layers(function))
        assert checked, f"{module.__name__}.{function.__qualname__} is not checked"
        typing.get_type_hints(inspect.unwrap(function), include_extras=True)  # a NameError would switch the check off


@pytest.mark.parametrize("name", sorted(REFUSE_IN_WORDS))
def test_exceptions_from_the_check_exist(name: str) -> None:
    found: object = engines if name.startswith("engines") else viewers
    for part in name.split(".")[1:]:
        found = getattr(found, part)
    assert callable(found)
