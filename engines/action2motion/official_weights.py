"""Checkpoints of the released Action2Motion: reading them, their names and ours, and the sizes they tell.

Letters: J joints, C classes, Z latent, H hidden.
"""

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

from engines.action2motion.networks import GaussianGRU, GeneratorGRU, LieHead, PlainHead
from engines.action2motion.official_lie import SKELETONS
from engines.errors import CheckpointError

_ACCEPTED = (
    "accepted: a .safetensors file with names like prior_net.embed.weight, or a file of torch.save holding a dict of "
    "the state dicts prior_net, decoder and (optionally) posterior_net"
)
_SECTIONS = ("prior_net", "posterior_net", "decoder")
_PREFIXES = {"prior_net": "prior", "posterior_net": "posterior", "decoder": "generator"}
_CELL = re.compile(r"gru\.(\d+)\.(weight_ih|weight_hh|bias_ih|bias_hh)")
_LAYER = re.compile(r"gru\.(weight_ih|weight_hh|bias_ih|bias_hh)_l(\d+)")


@dataclass(frozen=True)
class OfficialConfig:
    """Sizes of a released model, all told by the shapes of its weights."""

    joints: int
    """J; tells the data set."""
    classes: int
    """C, number of action labels."""
    latent_size: int
    """Z."""
    hidden_size: int
    """H of all three networks."""
    prior_layers: int
    """GRU layers of the prior."""
    posterior_layers: int
    """GRU layers of the posterior; 0 when the checkpoint has none."""
    generator_layers: int
    """GRU layers of the decoder."""
    lie: bool
    """The decoder gives a root translation and so(3) parameters, not joint positions."""
    time_counter: bool
    """The condition ends with i / (T - 1)."""

    @property
    def condition_size(self) -> int:
        """Features of the condition: one-hot label and time counter."""
        return self.classes + self.time_counter


def from_official(state: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Weights under the release's names -> under ours.

    `prior_net.gru.0.weight_ih` becomes `prior.gru.weight_ih_l0`, `decoder.output.weight` becomes `head.output.weight`.

    Args:
        state: names with the prefixes prior_net, posterior_net and decoder.
    """
    renamed = {}
    for name, value in state.items():
        section, _, rest = name.partition(".")
        ours = "head" if section == "decoder" and rest.startswith("output") else _PREFIXES.get(section, section)
        renamed[f"{ours}." + _CELL.sub(r"gru.\2_l\1", rest)] = value
    return renamed


def to_official(state: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Weights (or gradients) under our names -> under the release's; inverse of `from_official`."""
    sections = {ours: official for official, ours in _PREFIXES.items()} | {"head": "decoder"}
    renamed = {}
    for name, value in state.items():
        section, _, rest = name.partition(".")
        renamed[f"{sections.get(section, section)}." + _LAYER.sub(r"gru.\2.\1", rest)] = value
    return renamed


def read_state(path: str | Path) -> dict[str, Tensor]:
    """The weights in a checkpoint, under the release's names. No code in the file is run.

    Raises:
        CheckpointError: no such file, damaged, or not an Action2Motion checkpoint.
    """
    path = Path(path)
    if not path.is_file():
        raise CheckpointError(f"{path}: there is no such file; {_ACCEPTED}.")
    try:
        if path.suffix == ".safetensors":
            content = load_file(path)
        else:
            content = torch.load(path, map_location="cpu", weights_only=True)
    except (SafetensorError, pickle.UnpicklingError, BadZipFile, RuntimeError, EOFError, ValueError, OSError) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise CheckpointError(f"{path}: cannot be read as weights ({first}); {_ACCEPTED}.") from error
    return _flattened(content, path)


def _flattened(content: object, path: Path) -> dict[str, Tensor]:
    """Tensors of the networks under `section.name`, from nested or flat dicts; the optimisers' are left out."""
    if not isinstance(content, Mapping):
        raise CheckpointError(f"{path}: holds a {type(content).__name__}, not a dict; {_ACCEPTED}.")
    flat: dict[str, Tensor] = {}
    for name, value in content.items():
        if isinstance(value, Mapping) and name in _SECTIONS:
            pairs = ((f"{name}.{str(key).removeprefix('module.')}", tensor) for key, tensor in value.items())
            flat |= {key: tensor for key, tensor in pairs if isinstance(tensor, Tensor)}
        elif isinstance(value, Tensor) and str(name).partition(".")[0] in _SECTIONS:
            flat[name] = value
    missing = [section for section in ("prior_net", "decoder") if not any(k.startswith(section + ".") for k in flat)]
    if missing:
        found = ", ".join(sorted({str(name).partition(".")[0] for name in content})[:8]) or "nothing"
        raise CheckpointError(f"{path}: has no {' and no '.join(missing)} (it has {found}); {_ACCEPTED}.")
    return flat


def infer_config(state: Mapping[str, Tensor], time_counter: bool | None = None) -> OfficialConfig:
    """Sizes from the shapes of weights under the release's names.

    Shapes tell the number of classes and the time counter only together. The counter is taken to be there where the
    classes left over are as many as a data set of that many joints has; else as the release trained: with Lie, not
    without.

    Args:
        state: of `read_state`.
        time_counter: overrules that.

    Raises:
        CheckpointError: a weight is missing or sizes contradict each other.
    """
    try:
        hidden, prior_input = state["prior_net.embed.weight"].shape
        latent = state["prior_net.mu_net.weight"].shape[0]
        pose = state["decoder.output.weight"].shape[0]
        generator_input = state["decoder.embed.weight"].shape[1]
    except (KeyError, ValueError) as error:
        raise CheckpointError(
            f"the checkpoint is not Action2Motion's: {error} is missing or of a wrong shape."
        ) from None
    lie, condition = "decoder.output_lie.weight" in state, prior_input - pose
    if pose % 3 or condition < 1 or generator_input != prior_input + latent:
        raise CheckpointError(
            f"the checkpoint's sizes contradict each other: pose {pose}, prior input {prior_input}, latent {latent}, "
            f"decoder input {generator_input}; accepted: a pose of 3 numbers a joint, then [pose, condition] and "
            "[pose, condition, latent]."
        )
    if time_counter is None:
        skeleton = next((s for s in SKELETONS.values() if 3 * len(s) == pose), None)
        known = len(skeleton.actions) if skeleton else 0
        time_counter = lie if known not in (condition, condition - 1) else known == condition - 1
    layers = {section: sum(f"{section}.gru.{i}.weight_ih" in state for i in range(99)) for section in _SECTIONS}
    return OfficialConfig(
        joints=pose // 3,
        classes=condition - time_counter,
        latent_size=latent,
        hidden_size=hidden,
        prior_layers=layers["prior_net"],
        posterior_layers=layers["posterior_net"],
        generator_layers=layers["decoder"],
        lie=lie,
        time_counter=time_counter,
    )


class OfficialNetworks(nn.Module):
    """Prior, posterior, generator and head of a released model.

    Args:
        config: their sizes.
    """

    def __init__(self, config: OfficialConfig) -> None:
        super().__init__()
        self.config = config
        known, latent, size = 3 * config.joints + config.condition_size, config.latent_size, config.hidden_size
        self.prior = GaussianGRU(known, latent, size, config.prior_layers)
        self.posterior = GaussianGRU(known, latent, size, config.posterior_layers) if config.posterior_layers else None
        self.generator = GeneratorGRU(known + latent, size, config.generator_layers)
        self.head = LieHead(size, config.joints) if config.lie else PlainHead(size, 3 * config.joints)


def load_official(path: str | Path, time_counter: bool | None = None) -> OfficialNetworks:
    """The networks of an authors' checkpoint, on the CPU, in evaluation mode.

    Args:
        path: .safetensors with names like `prior_net.embed.weight`, or a file of `torch.save` (.tar, .pth, ...)
            holding a dict of the state dicts `prior_net`, `decoder` and (optionally) `posterior_net`, whatever else
            it holds (optimisers, iteration).
        time_counter: see `infer_config`.

    Raises:
        CheckpointError: the file is missing, damaged or of another architecture.
    """
    state = read_state(path)
    try:
        networks = OfficialNetworks(infer_config(state, time_counter))
        networks.load_state_dict(from_official(state))
    except (CheckpointError, RuntimeError) as error:
        raise CheckpointError(f"{path}: {error}") from error
    return networks.eval()
