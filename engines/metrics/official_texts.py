"""The released co-embedding of sentences and motions, in which Text2Motion's and TM2T's published figures are measured.

GRUs over word vectors with tags on one side, over snippets of normalised features without contacts on the other. Where
it departs from what one expects:

- both outputs are sorted by the motions' lengths (`released_order`); ours come in the order of what was given;
- what does not match a sentence while it is trained may be the motion that does (`contrastive_terms`, shift 0).

Letters: B batch, N words, E of a word vector, K tags, T frames, D features, C of the space.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional as nnf
from torch.nn.utils.rnn import pack_padded_sequence

from engines.errors import CheckpointError
from engines.text2motion.networks import SLOPE, UNIT, SnippetEncoder, WordReader
from engines.text2motion.official_weights import read_states

HIDDEN_FEATURES = 4
"""Foot contacts, which are not looked at."""
MARGIN = 10.0
_ACCEPTED = "accepted: a checkpoint with text_encoder, motion_encoder and movement_encoder"


class TextSide(nn.Module):
    """Sentences -> points."""

    def __init__(self, word: int, tags: int, hidden: int, size: int) -> None:
        super().__init__()
        self.reader = WordReader(word, tags, hidden)
        self.head = _head(hidden, size)

    def forward(self, words: Tensor, tags: Tensor, lengths: Tensor) -> Tensor:
        """Word vectors (B, N, E) with tags (B, N, K), of sentences of `lengths` words -> (B, C)."""
        return self.head(self.reader(words, tags, lengths).sentence)


class MotionSide(nn.Module):
    """Motions -> points."""

    def __init__(self, features: int, between: int, snippet: int, hidden: int, size: int) -> None:
        super().__init__()
        self.encoder = SnippetEncoder(features, between, snippet)
        self.input = nn.Linear(snippet, hidden)
        self.start = nn.Parameter(torch.randn(2, 1, hidden))
        self.gru = nn.GRU(hidden, hidden, batch_first=True, bidirectional=True)
        self.head = _head(hidden, size)

    def forward(self, features: Tensor, frames: Tensor) -> Tensor:
        """Normalised features (B, T, D), contacts at their end, of motions of so many frames -> (B, C)."""
        snippets = self.input(self.encoder(features[..., :-HIDDEN_FEATURES]))
        packed = pack_padded_sequence(snippets, (frames // UNIT).cpu(), batch_first=True, enforce_sorted=False)
        _, last = self.gru(packed, self.start.expand(-1, len(features), -1).contiguous())
        return self.head(last.transpose(0, 1).flatten(1))


class OfficialCoEmbedding(nn.Module):
    """Both sides; `load` makes one of an authors' checkpoint."""

    def __init__(self, text: TextSide, motion: MotionSide) -> None:
        super().__init__()
        self.text, self.motion = text, motion

    @classmethod
    def load(cls, path: str | Path) -> OfficialCoEmbedding:
        """The co-embedding of a checkpoint, its sizes told by the weights, in evaluation mode.

        Raises:
            CheckpointError: the file is missing, damaged, or of another network.
        """
        try:
            made = co_embedding_of(read_states(Path(path))[0])
        except (KeyError, ValueError, RuntimeError) as error:
            reason = " ".join(str(error).split())[:300]
            raise CheckpointError(f"{path}: not a released co-embedding ({reason}); {_ACCEPTED}.") from error
        return made.eval().requires_grad_(False)


def co_embedding_of(state: Mapping[str, Tensor]) -> OfficialCoEmbedding:
    """The co-embedding whose weights these are, under the release's names.

    Raises:
        KeyError, ValueError, RuntimeError: a weight is missing or of another shape.
    """
    ours = {_our_name(name): value for name, value in state.items() if name.split(".")[0] in _SIDES}
    word, tags = ours["text.reader.tag.weight"].shape
    size, hidden = ours["text.head.3.weight"].shape
    between, features, _ = ours["motion.encoder.first.weight"].shape
    snippet = ours["motion.encoder.out.weight"].shape[0]
    motion_hidden = ours["motion.input.weight"].shape[0]
    made = OfficialCoEmbedding(
        TextSide(word, tags, hidden, size), MotionSide(features, between, snippet, motion_hidden, size)
    )
    made.load_state_dict(ours)
    return made


def released_order(frames: Tensor) -> np.ndarray:
    """(B,) places in the order of the release's outputs: the longest motion first."""
    return np.argsort(frames.numpy())[::-1].copy()


def contrastive_terms(texts: Tensor, motions: Tensor, shift: int, margin: float = MARGIN) -> dict[str, Tensor]:
    """What the release trains it by: pairs near each other, and a sentence `margin` away from a motion further on.

    Args:
        texts: (B, C) points.
        motions: (B, C) points of the motions they describe.
        shift: how much further on; 0 takes the motion itself.
        margin: distance from which on a wrong pair costs nothing.
    """
    wrong = motions.roll(-shift, 0)
    near, far = nnf.pairwise_distance(texts, motions), nnf.pairwise_distance(texts, wrong)
    return {"positive": near.square().mean(), "negative": (margin - far).clamp_min(0).square().mean()}


_SIDES = ("text_encoder", "motion_encoder", "movement_encoder")
_READER = ("tag.", "input.", "start", "gru.")


def _our_name(name: str) -> str:
    """One name of the release -> ours."""
    side, _, rest = name.partition(".")
    for theirs, own in (("pos_emb.", "tag."), ("input_emb.", "input."), ("output_net.", "head."), ("hidden", "start")):
        rest = own + rest.removeprefix(theirs) if rest.startswith(theirs) else rest
    if side == "text_encoder":
        return f"text.reader.{rest}" if rest.startswith(_READER) else f"text.{rest}"
    if side == "motion_encoder":
        return f"motion.{rest}"
    for theirs, own in (("main.0.", "first."), ("main.3.", "second."), ("out_net.", "out.")):
        rest = own + rest.removeprefix(theirs) if rest.startswith(theirs) else rest
    return f"motion.encoder.{rest}"


def _head(hidden: int, size: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(2 * hidden, hidden), nn.LayerNorm(hidden), nn.LeakyReLU(SLOPE), nn.Linear(hidden, size)
    )
