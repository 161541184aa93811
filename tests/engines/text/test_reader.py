"""What a prompt is taken to ask for."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from engines import text
from engines.errors import CheckpointError
from engines.evaluation.prompts import PROMPTS
from engines.evaluation.prompts_more import MORE
from engines.text import reader
from engines.text.everyday import EVERYDAY


@pytest.fixture(scope="module")
def shipped() -> reader.PromptReader:
    return reader.load()


@pytest.mark.parametrize(
    ("prompt", "action", "style"),
    [
        ("an old man waves with his left hand", "wave left hand", "elderly"),
        ("wave the RIGHT hand", "wave right hand", None),
        ("someone walks in a proud manner", "walk", "proud"),
        ("she sits down on the sofa", "sit down", None),
        ("bake a chocolate cake", None, None),
    ],
)
def test_actions_and_styles_are_read(shipped, prompt, action, style) -> None:
    found = shipped.read([prompt])[0]
    assert (found.action, found.style) == (action, style)
    assert len(found.nearest) == 3
    assert 0 <= found.sure <= 1


def test_most_prompts_that_nobody_trained_on_are_read(shipped) -> None:
    prompts = [*PROMPTS, *MORE]
    found = shipped.read([line for line, _ in prompts])
    right = [one.action in accepted for one, (_, accepted) in zip(found, prompts, strict=True)]
    assert sum(right) / len(right) > 0.85


def test_prompts_that_measure_are_no_sentences_to_learn_from() -> None:
    learned = {line.lower().strip(" .!?") for lines in EVERYDAY.values() for line in lines}
    assert [line for line, _ in (*PROMPTS, *MORE) if line.lower().strip(" .!?") in learned] == []


def test_nothing_asked_nothing_read(shipped) -> None:
    assert shipped.read([]) == []


def test_what_is_saved_reads_alike(tmp_path: Path) -> None:
    torch.manual_seed(0)
    made = reader.PromptReader(("walk", "run", "jump"), ("happy",), text.load()).eval()
    with torch.no_grad():
        made.action.weight.mul_(20)
    reader.save(made, tmp_path / "one.safetensors")
    again = reader.load(tmp_path / "one.safetensors")
    said = ["a person hops", "walk"]
    assert [one.nearest for one in again.read(said)] == [one.nearest for one in made.read(said)]
    with pytest.raises(CheckpointError, match=r"train_prompt_reader"):
        reader.load(tmp_path / "none.safetensors")
