"""The papers' released action classifiers, whose last hidden layer the published FIDs are measured in.

Action2Motion and MultiAct have the same network, a GRU and two linear layers. Where it departs from what one expects:

- the GRU starts from a normal random state, in testing too, new at every call (`OfficialClassifier.random_state`);
  ours is given the state, and starts from zeros if it is not;
- MultiAct's motions are padded with zeros and read to the last slot, pads included, after the first frame's root has
  been subtracted from every joint of every slot, so that a pad becomes minus that root (`centred_on_first_root`).

The released scores on top of it are in `official_scores`. Letters: B batch, T frames, D numbers a pose, H hidden,
F features, C classes.
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from engines.errors import CheckpointError, OutOfRangeError
from engines.metrics.recognition import Recognised

_ACCEPTED = (
    "accepted: a .safetensors file, or a file of torch.save, with recurrent.weight_ih_l0 and the other weights of a "
    "GRU, linear1 and linear2"
)
_FIRST = "recurrent.weight_ih_l0"


class OfficialClassifier(nn.Module):
    """The released classifier; the names of its weights are the release's.

    Args:
        pose_size: D.
        hidden_size: H.
        layers: of the GRU.
        feature_size: F, 30 in both releases.
        classes: C.
    """

    def __init__(self, pose_size: int, hidden_size: int, layers: int, feature_size: int, classes: int) -> None:
        super().__init__()
        self.recurrent = nn.GRU(pose_size, hidden_size, layers, batch_first=True)
        self.linear1 = nn.Linear(hidden_size, feature_size)
        self.linear2 = nn.Linear(feature_size, classes)

    def forward(self, motions: Tensor, state: Tensor | None = None) -> Recognised:
        """Motions (B, T, D) -> features (B, F), of the GRU's last step, and logits (B, C).

        Args:
            motions: joint positions in the units of the data set.
            state: (layers, B, H) the GRU starts from; zeros by default.

        Raises:
            OutOfRangeError: motions or state of another shape.
        """
        if motions.ndim != 3 or motions.shape[-1] != self.recurrent.input_size or motions.shape[1] == 0:
            raise OutOfRangeError(
                "shape of motions", tuple(motions.shape), f"(motions, 1 or more frames, {self.recurrent.input_size})"
            )
        wanted = (self.recurrent.num_layers, len(motions), self.recurrent.hidden_size)
        if state is not None and state.shape != wanted:
            raise OutOfRangeError("shape of the state", tuple(state.shape), f"{wanted}")
        hidden, _ = self.recurrent(motions, state)  # (B, T, H)
        features = torch.tanh(self.linear1(hidden[:, -1]))
        return Recognised(features, self.linear2(features))

    def random_state(self, batch: int, generator: torch.Generator | None = None) -> Tensor:
        """(layers, B, H) a state as the release draws it, standard normal."""
        shape = (self.recurrent.num_layers, batch, self.recurrent.hidden_size)
        weight = self.linear1.weight
        return torch.randn(shape, generator=generator, dtype=weight.dtype).to(weight.device)

    @classmethod
    def load(cls, path: str | Path) -> OfficialClassifier:
        """The classifier of an authors' checkpoint, its sizes told by the weights, in evaluation mode.

        Raises:
            CheckpointError: the file is missing, damaged, or of another network.
        """
        state = _read(Path(path))
        try:
            layers = sum(name.startswith("recurrent.weight_ih_l") for name in state)
            hidden, pose = state["recurrent.weight_hh_l0"].shape[1], state[_FIRST].shape[1]
            features, classes = state["linear1.weight"].shape[0], state["linear2.weight"].shape[0]
            made = cls(pose, hidden, layers, features, classes)
            made.load_state_dict(dict(state))
        except (KeyError, IndexError, RuntimeError) as error:
            raise CheckpointError(f"{path}: not a released action classifier ({error}); {_ACCEPTED}.") from error
        return made.eval().requires_grad_(False)


def centred_on_first_root(motions: Tensor) -> Tensor:
    """MultiAct's input: joints (B, T, 3J) less the first joint of the first frame, the zeros of pads too.

    Raises:
        OutOfRangeError: no frames, or poses that are not made of points.
    """
    if motions.ndim != 3 or motions.shape[1] == 0 or motions.shape[2] % 3:
        raise OutOfRangeError("shape of motions", tuple(motions.shape), "(motions, 1 or more frames, 3 times joints)")
    joints = motions.unflatten(-1, (-1, 3))
    return (joints - joints[:, :1, :1]).flatten(-2)


def _read(path: Path) -> Mapping[str, Tensor]:
    """The weights by name, also where a training's dict of dicts holds them."""
    try:
        found: Any = load_file(path) if path.suffix == ".safetensors" else torch.load(path, "cpu", weights_only=True)
    except (OSError, SafetensorError, pickle.UnpicklingError, BadZipFile, RuntimeError, EOFError) as error:
        raise CheckpointError(f"{path}: cannot be read ({error}); {_ACCEPTED}.") from error
    sections = [found, *found.values()] if isinstance(found, Mapping) else []
    state = next((s for s in sections if isinstance(s, Mapping) and isinstance(s.get(_FIRST), Tensor)), None)
    if state is None:
        raise CheckpointError(f"{path}: has no {_FIRST}; {_ACCEPTED}.")
    return state
