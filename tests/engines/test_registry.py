"""Engines are listed where their weights are, by what these hold."""

from __future__ import annotations

import json

import pytest

import engines
from engines import registry
from engines.errors import UnknownLabelError


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(registry, "WEIGHTS", tmp_path)

    def put(name: str, *parts: str) -> None:
        (tmp_path / f"{name}.safetensors").write_bytes(b"")
        (tmp_path / f"{name}.json").write_text(json.dumps({"parts": parts}))

    return put


def test_without_weights_nobody_is_there(folder):
    assert (registry.available(), registry.stylisers(), registry.captioners()) == ({}, {}, {})


def test_weights_that_only_describe_make_no_motions(folder):
    folder("loom")
    folder("tm2t", "tokenizer", "motion2text")
    assert list(registry.available()) == ["loom"]
    assert list(registry.captioners()) == ["tm2t"]


def test_weights_that_only_make_motions_describe_none(folder):
    folder("tm2t", "tokenizer", "text2motion")
    assert list(registry.available()) == ["tm2t"]
    assert registry.captioners() == {}


def test_an_engine_nobody_knows_is_named():
    with pytest.raises(UnknownLabelError, match="tm3t"):
        engines.load("tm3t")
