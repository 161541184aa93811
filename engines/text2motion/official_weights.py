"""Checkpoints of the released Text2Motion: reading them, their names and ours, and the sizes they tell."""

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
from engines.text2motion.model import Autoencoder, Sizes, TemporalVAE
from engines.text2motion.networks import LengthEstimator

HIDDEN_FEATURES = 4
"""Foot contacts, which the encoder is not shown."""
_ACCEPTED = "accepted: .safetensors, or a file of torch.save that holds dicts of weights"
_TO_OURS = (
    (r"^text_enc\.", "reader."), (r"^att_layer\.W_q\.", "attention.query."), (r"^att_layer\.W_k\.", "attention.key."),
    (r"^att_layer\.W_v\.", "attention.value."), (r"^seq_pri\.", "prior."), (r"^seq_post\.", "posterior."),
    (r"^seq_dec\.", "generator."), (r"pos_emb\.", "tag."), (r"input_emb\.", "input."),
    (r"(^|\.)hidden$", r"\1start"), (r"\.emb\.", ".embed."), (r"\.z2init\.", ".first."), (r"\.gru\.(\d)", r".cells.\1"),
    (r"\.mu_net\.", ".mean."), (r"\.logvar_net\.", ".logvar."), (r"\.output\.", ".head."),
    (r"^(mov_enc|movement_enc)\.", "encoder."), (r"^(mov_dec|movement_dec)\.", "decoder."),
    (r"^encoder\.main\.0\.", "encoder.first."), (r"^encoder\.main\.3\.", "encoder.second."),
    (r"^decoder\.main\.0\.", "decoder.first."), (r"^decoder\.main\.2\.", "decoder.second."), (r"\.out_net\.", ".out."),
    (r"^estimator\.", ""),
)  # fmt: skip
_DROPPED = re.compile(r"positional_encoder\.")
_OF_THE_READER = re.compile(r"^(tag|input|gru|start)\b")


def our_name(name: str) -> str:
    """One name of the release, network's prefix included -> ours.

    Those of the length estimator have the prefix `estimator`.
    """
    estimator = name.startswith("estimator.")
    for pattern, ours in _TO_OURS:
        name = re.sub(pattern, ours, name)
    if not estimator:
        return name
    return f"reader.{name}" if _OF_THE_READER.match(name) else re.sub(r"^output\.", "head.", name)


def from_official(state: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Weights under the release's names -> under ours; tables of positions are left out."""
    return {our_name(name): value for name, value in state.items() if not _DROPPED.search(name)}


@dataclass(frozen=True)
class OfficialParts:
    """Networks of the release, those that were found."""

    vae: TemporalVAE | None = None
    autoencoder: Autoencoder | None = None
    lengths: LengthEstimator | None = None


def autoencoder_of(state: Mapping[str, Tensor]) -> Autoencoder:
    """The autoencoder whose weights these are, prefixes mov_enc and mov_dec (or movement_enc, movement_dec).

    Raises:
        CheckpointError: a weight is missing or of another shape.
    """
    ours = {k: v for k, v in from_official(state).items() if k.startswith(("encoder.", "decoder."))}
    try:
        into, shown, _ = ours["encoder.first.weight"].shape
        code, out, _ = ours["decoder.first.weight"].shape
        features = ours["decoder.out.weight"].shape[0]
        net = Autoencoder(features, features - shown, (into, out), code)
        net.load_state_dict(ours)
    except (KeyError, ValueError, RuntimeError) as error:
        raise CheckpointError(f"these are not the weights of Text2Motion's autoencoder: {_first(error)}") from error
    return net


def vae_of(state: Mapping[str, Tensor]) -> TemporalVAE:
    """The temporal VAE whose weights these are, prefixes text_enc, att_layer, seq_pri, seq_post and seq_dec.

    Raises:
        CheckpointError: a weight is missing or of another shape.
    """
    parts = ("reader.", "attention.", "prior.", "posterior.", "generator.")
    ours = {name: value for name, value in from_official(state).items() if name.startswith(parts)}
    try:
        word, tags = ours["reader.tag.weight"].shape
        latent, latent_hidden = ours["prior.mean.weight"].shape
        layers = len([name for name in ours if re.fullmatch(r"generator\.cells\.\d+\.weight_ih", name)])
        code, motion_hidden = ours["generator.head.3.weight"].shape
        attention = ours["attention.query.weight"].shape[0]
        hidden = ours["reader.input.weight"].shape[0]
        sizes = Sizes(word, tags, hidden, attention, latent, latent_hidden, motion_hidden, code, layers, release=True)
        net = TemporalVAE(sizes)
        net.load_state_dict(ours)
    except (KeyError, ValueError, RuntimeError) as error:
        raise CheckpointError(f"these are not the weights of Text2Motion's VAE: {_first(error)}") from error
    return net


def lengths_of(state: Mapping[str, Tensor]) -> LengthEstimator:
    """The length estimator whose weights these are, without prefix.

    Raises:
        CheckpointError: a weight is missing or of another shape.
    """
    ours = from_official({f"estimator.{name}": value for name, value in state.items()})
    try:
        word, tags = ours["reader.tag.weight"].shape
        last = max(int(name.split(".")[1]) for name in ours if name.startswith("head."))
        classes = ours[f"head.{last}.weight"].shape[0]
        net = LengthEstimator(word, tags, ours["reader.input.weight"].shape[0], classes)
        net.load_state_dict(ours)
    except (KeyError, ValueError, RuntimeError) as error:
        raise CheckpointError(f"these are not the weights of Text2Motion's lengths: {_first(error)}") from error
    return net


def parts_of(path: Path) -> OfficialParts:
    """The networks in a checkpoint, in evaluation mode.

    Raises:
        CheckpointError: the file is missing, damaged, or holds none of them.
    """
    named, single = read_states(path)
    found: dict[str, nn.Module] = {}
    for state in single:
        if "output.0.weight" in state and "pos_emb.weight" in state:
            found["lengths"] = lengths_of(state)
    prefixes = {name.partition(".")[0] for name in named}
    if "seq_pri" in prefixes:
        found["vae"] = vae_of(named)
    if prefixes & {"mov_dec", "movement_dec"}:
        found["autoencoder"] = autoencoder_of(named)
    if not found:
        raise CheckpointError(f"{path}: holds no network of Text2Motion; {_ACCEPTED}.")
    return OfficialParts(**{name: net.eval().requires_grad_(False) for name, net in found.items()})  # type: ignore[arg-type]


def read_states(path: Path) -> tuple[dict[str, Tensor], list[dict[str, Tensor]]]:
    """All weights of a checkpoint: under the names of their sections, and section by section. No code in it is run.

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
    sections = [flat]
    named = dict(flat)
    for section, inner in content.items():
        if isinstance(inner, Mapping):
            held = {str(k).removeprefix("module."): v for k, v in inner.items() if isinstance(v, Tensor)}
            sections.append(held)
            named |= {f"{section}.{name}": value for name, value in held.items()}
    return named, sections


def _first(error: Exception) -> str:
    return " ".join(str(error).split())[:300]
