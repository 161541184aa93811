"""Checkpoints of the released TM2T: reading them, their names and ours, and the sizes they tell."""

from __future__ import annotations

import pickle
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from engines.errors import CheckpointError
from engines.tm2t.attentive import AttentiveGRU, GRUSizes
from engines.tm2t.tokenizer import AveragedCodebook, Codebook, MotionTokenizer
from engines.tm2t.transformer import Sizes, Translator

HIDDEN_FEATURES = 4
"""Foot contacts, which the encoder is not shown."""
_ACCEPTED = "accepted: .safetensors, or a file of torch.save that holds dicts of weights"
_CELL = re.compile(r"^cells\.(\d+)\.")
_TO_OURS = (
    # of the transformer
    (r"layer_stack\.", "layers."), (r"slf_attn\.", "attention."), (r"enc_attn\.", "cross."), (r"pos_ffn\.", "feed."),
    (r"w_qs\.", "query."), (r"w_ks\.", "key."), (r"w_vs\.", "value."), (r"\.fc\.", ".out."),
    (r"feed\.w_1\.", "feed.inner."), (r"feed\.w_2\.", "feed.outer."), (r"layer_norm\.", "norm."),
    (r"src_word_emb\.", "embed."), (r"trg_word_emb\.", "embed."), (r"^encoder\.emb\.", "encoder.embed."),
    (r"^trg_word_prj\.", "head."),
    # of the attentive GRU
    (r"^text_encoder\.hidden$", "reader.start"), (r"^text_encoder\.input_emb\.", "reader.input."),
    (r"^text_encoder\.gru\.", "reader.gru."), (r"^motion_decoder_step\.input_emb\.", "embed."),
    (r"^motion_decoder_step\.z2init\.", "first."), (r"^motion_decoder_step\.att_layer\.W_q\.", "attention.query."),
    (r"^motion_decoder_step\.att_layer\.W_k\.", "attention.key."),
    (r"^motion_decoder_step\.att_layer\.W_v\.", "attention.value."),
    (r"^motion_decoder_step\.att_linear\.", "mix."), (r"^motion_decoder_step\.gru\.", "cells."),
    # of the tokenizer
    (r"^vq_encoder\.", "encoder."), (r"^vq_decoder\.", "decoder."), (r"^quantizer\.embedding\.", "codebook."),
    (r"\.?main\.", lambda m: ".layers." if m.group().startswith(".") else "layers."), (r"\.model\.", ".layers."),
)  # fmt: skip
_DROPPED = re.compile(r"position_enc\.|^motion_decoder_step\.trg_word_prj\.")


def from_official(state: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Weights of one network under the release's names -> under ours.

    Position tables, and output layers that are the embedding once more, are left out.
    """
    return {our_name(name): value for name, value in state.items() if not _DROPPED.search(name)}


def our_name(name: str) -> str:
    """One name of the release -> ours."""
    for pattern, ours in _TO_OURS:
        name = re.sub(pattern, ours, name)
    return name


def read_states(path: Path) -> list[dict[str, Tensor]]:
    """All dicts of weights in a checkpoint. No code in the file is run.

    Raises:
        CheckpointError: no such file, or damaged.
    """
    if not path.is_file():
        raise CheckpointError(f"{path}: there is no such file; {_ACCEPTED}.")
    try:
        if path.suffix == ".safetensors":
            content: object = load_file(path)
        else:
            content = torch.load(path, map_location="cpu", weights_only=True)
    except (SafetensorError, pickle.UnpicklingError, BadZipFile, RuntimeError, EOFError, ValueError, OSError) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise CheckpointError(f"{path}: cannot be read as weights ({first}); {_ACCEPTED}.") from error
    if not isinstance(content, Mapping):
        raise CheckpointError(f"{path}: holds a {type(content).__name__}, not a dict; {_ACCEPTED}.")
    flat = {str(name): value for name, value in content.items() if isinstance(value, Tensor)}
    merged = dict(flat)
    states = []
    for section, inner in content.items():
        if not isinstance(inner, Mapping):
            continue
        named = {str(k).removeprefix("module."): v for k, v in inner.items() if isinstance(v, Tensor)}
        if str(section) in {"vq_encoder", "vq_decoder", "quantizer", "discriminator"}:
            merged |= {f"{section}.{name}": value for name, value in named.items()}
        elif named:
            states.append(named)
    return [*states, merged] if merged else states


@dataclass(frozen=True)
class OfficialParts:
    """Networks of the release, those that were found."""

    tokenizer: MotionTokenizer | None = None
    text2motion: AttentiveGRU | Translator | None = None
    motion2text: Translator | None = None


def tokenizer_of(state: Mapping[str, Tensor], averaged: bool = False) -> MotionTokenizer:
    """The tokenizer whose weights these are; an encoder and a codebook alone get a decoder without weights.

    Args:
        state: names with the prefixes vq_encoder, quantizer and vq_decoder.
        averaged: with the release's class of a codebook that follows by averages.

    Raises:
        CheckpointError: a weight is missing or of another shape.
    """
    ours = from_official({k: v for k, v in state.items() if not k.startswith("discriminator.")})
    try:
        codes, size = ours["codebook.weight"].shape
        channels = [ours[k].shape[0] for k in ours if re.fullmatch(r"encoder\.layers\.\d+\.weight", k)]
        features = ours["encoder.layers.0.weight"].shape[1] + HIDDEN_FEATURES
        convolutions = [ours[k] for k in ours if re.fullmatch(r"decoder\.layers\.\d+\.weight", k)]
        blocks = len([k for k in ours if re.fullmatch(r"decoder\.layers\.\d+\.layers\.0\.weight", k)])
        widths = [convolutions[0].shape[1], *(c.shape[0] for c in convolutions[:-1])] if convolutions else [size]
        book = AveragedCodebook(codes, size, release=True) if averaged else Codebook(codes, size)
        net = MotionTokenizer(features, HIDDEN_FEATURES, channels, widths, blocks, book)
        _fill(net, ours, lacking=() if convolutions else ("decoder.",))
    except (KeyError, IndexError, ValueError, RuntimeError) as error:
        raise CheckpointError(f"these are not the weights of TM2T's tokenizer: {_first(error)}") from error
    return net


def gru_of(state: Mapping[str, Tensor]) -> AttentiveGRU:
    """The attentive GRU whose weights these are, text_encoder and motion_decoder_step.

    Raises:
        CheckpointError: a weight is missing or of another shape.
    """
    ours = from_official(state)
    try:
        hidden, text = ours["reader.input.weight"].shape
        tokens, width = ours["embed.weight"].shape
        layers = sum(_CELL.match(name) is not None and name.endswith("weight_ih") for name in ours)
        sizes = GRUSizes(text, tokens, hidden, width, layers, late="mix.3.weight" in ours, release=True)
        net = AttentiveGRU(sizes)
        _fill(net, ours)
    except (KeyError, ValueError, RuntimeError) as error:
        raise CheckpointError(f"these are not the weights of TM2T's attentive GRU: {_first(error)}") from error
    return net


def translator_of(state: Mapping[str, Tensor], heads: int = 8) -> Translator:
    """The transformer whose weights these are.

    Args:
        state: names with the prefixes encoder and decoder, and trg_word_prj.
        heads: shapes do not tell how many.

    Raises:
        CheckpointError: a weight is missing or of another shape.
    """
    ours = from_official(state)
    try:
        vectors_in = "encoder.emb.weight" in state
        source = ours["encoder.embed.weight"].shape[1 if vectors_in else 0]
        target, width = ours["head.weight"].shape
        tied = torch.equal(ours["head.weight"], ours["decoder.embed.weight"])
        embedded = ours["decoder.embed.weight"].shape
        inner = ours["encoder.layers.0.attention.query.weight"].shape[0]
        sizes = Sizes(
            source=source,
            target=target,
            width=width,
            inner=ours["encoder.layers.0.feed.inner.weight"].shape[0],
            layers=len([k for k in ours if re.fullmatch(r"encoder\.layers\.\d+\.feed\.inner\.weight", k)]),
            heads=heads,
            head_size=inner // heads,
            source_places=_places(state, "encoder"),
            target_places=_places(state, "decoder"),
            source_vectors=vectors_in,
            target_vectors=0 if embedded[0] == target else embedded[1],
            tied=tied,
        )
        net = Translator(sizes)
        _fill(net, {name: value for name, value in ours.items() if not (tied and name == "head.weight")})
    except (KeyError, ValueError, RuntimeError) as error:
        raise CheckpointError(f"these are not the weights of TM2T's transformer: {_first(error)}") from error
    return net


def parts_of(path: Path, heads: int = 8) -> OfficialParts:
    """The networks in a checkpoint, in evaluation mode.

    Raises:
        CheckpointError: the file is missing, damaged, or holds none of them.
    """
    found: dict[str, nn.Module] = {}
    for state in read_states(path):
        if "text_encoder.hidden" in state:
            found["text2motion"] = gru_of(state)
        elif "vq_decoder.main.0.model.0.weight" in state or "vq_decoder.main.0.weight" in state:
            found["tokenizer"] = tokenizer_of(state)
        elif "encoder.emb.weight" in state:
            found["text2motion"] = translator_of(state, heads)
        elif "encoder.src_word_emb.weight" in state:
            found["motion2text"] = translator_of(state, heads)
    if not found:
        raise CheckpointError(f"{path}: holds no network of TM2T; {_ACCEPTED}.")
    return OfficialParts(**{name: net.eval().requires_grad_(False) for name, net in found.items()})  # type: ignore[arg-type]


def _places(state: Mapping[str, Tensor], side: str) -> int:
    table = state.get(f"{side}.position_enc.positional_encoding")
    return 256 if table is None else table.shape[-2]


def _fill(net: nn.Module, state: Mapping[str, Tensor], lacking: tuple[str, ...] = ()) -> None:
    found = net.load_state_dict(dict(state), strict=False)
    missing = [
        name for name in found.missing_keys if not name.startswith(lacking or ("/",)) and "codebook." not in name
    ]
    if missing or found.unexpected_keys:
        raise ValueError(f"missing {missing[:3]}, unexpected {found.unexpected_keys[:3]}")


def _first(error: Exception) -> str:
    return " ".join(str(error).split())[:300]
