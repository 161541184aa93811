"""Weights and settings beside each other: written, read, and what is said of files that do not fit."""

from __future__ import annotations

import hashlib

import pytest
import torch
from torch import nn

from engines import weights_file
from engines.errors import CheckpointError


def net(size: int = 3) -> nn.Module:
    torch.manual_seed(size)
    made = nn.Sequential(nn.Linear(2, size), nn.BatchNorm1d(size))
    made(torch.randn(8, 2))
    return made


def test_what_is_written_is_read_again(tmp_path) -> None:
    path = tmp_path / "mine.safetensors"
    one, other = net(), net()
    for value in other.state_dict().values():
        value.zero_()
    digest = weights_file.write(one.state_dict(), '{"size": 3}', path)
    assert digest == hashlib.sha256(path.read_bytes()).hexdigest()
    assert weights_file.read_settings(path, "train them") == '{"size": 3}\n'
    weights_file.fill(other, path)
    for name, value in one.state_dict().items():
        kept = other.state_dict()[name]
        assert kept.dtype == value.dtype
        exact = "running" in name or not value.is_floating_point()
        torch.testing.assert_close(kept, value, atol=0 if exact else 1e-3, rtol=0)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.json", "mine.safetensors"]


def test_files_that_do_not_fit(tmp_path) -> None:
    path = tmp_path / "mine.safetensors"
    with pytest.raises(CheckpointError, match="no such weights; train them"):
        weights_file.read_settings(path, "train them")
    weights_file.write(net().state_dict(), "{}", path)
    with pytest.raises(CheckpointError, match="do not fit their settings"):
        weights_file.fill(net(4), path)
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(CheckpointError, match="do not fit their settings"):
        weights_file.fill(net(), path)
    path.with_suffix(".json").unlink()
    with pytest.raises(CheckpointError, match="settings cannot be read"):
        weights_file.read_settings(path, "train them")
