"""The released MACVAE as it is, for the authors' checkpoint and its numbers; ours is `model`.

What departs from the paper, and from ours:

- 120 slots whatever is made; poses go in as axis-angle (156) and place (3), Z up, and come out as 6-D.
- Positions: the sinusoids' axes are exchanged, so that sine and cosine alternate over frames; in the decoder the second
  half of the channels starts anew where the transition ends.
- The encoder's last layers share one batch norm, padding counted, and average over the transition for z_p, over the
  action for z_c (the paper: both over all frames).
- The decoder looks back only (causal mask, causal convolution).
- The postprocessor changes the previous motion's frames too, which go in as rows of matrices and are read as columns;
  slots past the end are filled from a slot the decoder was never trained on.
- The divergence is divided by the batch size of the settings, the other terms by all slots; what is called the
  acceleration loss keeps accelerations small, real ones or not.

6-D and canonicalisation of the release are `engines.features.official_smplh`.
"""

from __future__ import annotations

from dataclasses import dataclass

import roma
import torch
from torch import Tensor, nn
from torch.nn import functional as nnf

from engines.errors import CheckpointError
from engines.text2motion.losses import divergence
from engines.text2motion.networks import Gaussian

SLOTS = 120
SEEN = 4
"""Frames of the previous motion that the prior sees."""
JOINTS = 52
_POSE, _ROT6D, _PLACE = 3 * JOINTS, 6 * JOINTS, 3
TRANSITION = 4
"""The label of transitions."""
_BATCH = 16
"""Size of a batch in the release's settings."""
_WIDE = 5
"""Frames of every convolution."""


@dataclass(frozen=True)
class Slots:
    """What is in the slots of a batch."""

    lengths: Tensor
    """(B, 3) frames of the previous motion, the transition and the action, one after the other."""
    labels: Tensor
    """(B, 3) of these parts."""

    @property
    def part(self) -> Tensor:
        """(B, 120) 0, 1 or 2; 3 past the end."""
        ends = self.lengths.cumsum(1)
        return (torch.arange(SLOTS)[None, :, None] >= ends[:, None]).sum(-1)

    @property
    def label(self) -> Tensor:
        """(B, 120) label of each slot; 0 past the end."""
        return nnf.pad(self.labels, (0, 1)).gather(1, self.part)

    @property
    def made(self) -> Slots:
        """Transition and action alone, from the first slot on."""
        lengths = self.lengths * torch.tensor([0, 1, 1])
        return Slots(lengths, self.labels)


def table(width: int) -> Tensor:
    """(120, H) positions with their axes exchanged."""
    rates = torch.exp(torch.arange(0, SLOTS, 2) * (-torch.log(torch.tensor(10_000.0)) / SLOTS))
    angles = torch.arange(width)[:, None] * rates
    return torch.stack([angles.sin(), angles.cos()], dim=-1).flatten(1).T


def layered(positions: Tensor, transition: Tensor) -> Tensor:
    """(B, 120, H) positions (120, H) whose second half begins anew after so many frames (B,)."""
    at = torch.arange(SLOTS)
    again = torch.where(at >= transition[:, None], at - transition[:, None], at)
    first, second = positions.chunk(2, dim=1)
    return torch.cat([first.expand(len(transition), -1, -1), second[again]], dim=-1)


class Convolution(nn.Module):
    """Five frames wide over time; stored as the release stores it."""

    def __init__(self, inputs: int, outputs: int, before: int) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.zeros(outputs, 1, _WIDE, inputs))
        self.bias = nn.Parameter(torch.zeros(outputs))
        self.before = before

    def forward(self, x: Tensor) -> Tensor:
        """(B, T, C) -> (B, T, C'); the first and the last frame stand for what is beyond them."""
        padded = nnf.pad(x.mT, (self.before, _WIDE - 1 - self.before), mode="replicate")
        return nnf.conv1d(padded, self.weight[:, 0].mT, self.bias).mT


class Encoder(nn.Module):
    """Poses, places and labels -> the posterior."""

    def __init__(self, width: int, heads: int, inner: int, layers: int, labels: int) -> None:
        super().__init__()
        self.action_embed = nn.Embedding(labels, width)
        self.pre_coding = nn.Linear(_POSE + _PLACE + width, width)
        layer = nn.TransformerEncoderLayer(width, heads, inner, 0.0, "gelu", batch_first=True)
        self.encoder = nn.TransformerEncoder(layer, layers, nn.LayerNorm(width), enable_nested_tensor=False)
        self.mean_conv, self.logvar_conv = Convolution(width, width, 2), Convolution(width, width, 2)
        self.bn = nn.BatchNorm1d(width)
        self.mean_fc, self.logvar_fc = nn.Linear(width, width), nn.Linear(width, width)
        self.register_buffer("positions", table(width), persistent=False)

    def forward(self, pose: Tensor, place: Tensor, slots: Slots) -> Gaussian:
        """Pose (B, 120, 156) and place (B, 120, 3)."""
        part = slots.part
        x = self.pre_coding(torch.cat([pose, place, self.action_embed(slots.label)], dim=-1)) + self.positions
        x = self.encoder(x, src_key_padding_mask=part == 3)
        mean, logvar = (
            fully(self.bn(convolution(x).mT).mT.relu())
            for convolution, fully in ((self.mean_conv, self.mean_fc), (self.logvar_conv, self.logvar_fc))
        )
        share = nnf.one_hot(part, 4)[..., 1:3] / slots.lengths[:, None, 1:].clamp_min(1)
        return Gaussian(share.mT @ mean, share.mT @ logvar)


class Prior(nn.Module):
    """The previous motion's last frames and the action's label -> the prior: PrevNet and CurrNet."""

    def __init__(self, width: int, labels: int) -> None:
        super().__init__()
        self.mean_actions, self.logvar_actions = nn.Embedding(labels, width), nn.Embedding(labels, width)
        self.pre_coder1, self.pre_coder2 = (nn.Linear(SEEN * (_POSE + _PLACE), width) for _ in range(2))
        self.bn = nn.BatchNorm1d(64)  # in checkpoints, used by nothing

    def forward(self, pose: Tensor, place: Tensor, slots: Slots) -> Gaussian:
        """Pose (B, 120, 156) and place (B, 120, 3), of which the last frames of the previous motion are seen."""
        at = slots.lengths[:, :1] - SEEN + torch.arange(SEEN)
        frames = torch.cat([pose, place], dim=-1)
        last = frames.gather(1, at[..., None].expand(-1, -1, frames.shape[-1])).flatten(1)
        mean, logvar = self.mean_actions(slots.labels[:, 1:]), self.logvar_actions(slots.labels[:, 1:])
        seen = torch.stack([self.pre_coder1(last), torch.zeros_like(mean[:, 0])], dim=1)
        spread = torch.stack([self.pre_coder2(last), torch.zeros_like(mean[:, 0])], dim=1)
        return Gaussian(mean + seen, logvar + spread)


class Decoder(nn.Module):
    """Latents -> 6-D and place of transition and action, from the first slot on."""

    positions: Tensor

    def __init__(self, width: int, heads: int, inner: int, layers: int) -> None:
        super().__init__()
        layer = nn.TransformerDecoderLayer(width, heads, inner, 0.0, "gelu", batch_first=True)
        self.decoder = nn.TransformerDecoder(layer, layers, nn.LayerNorm(width))
        self.post_conv = Convolution(width, _ROT6D + _PLACE, _WIDE - 1)
        self.register_buffer("positions", table(width), persistent=False)

    def forward(self, z: Tensor, slots: Slots) -> Tensor:
        """z (B, 2, H) -> (B, 120, 315)."""
        made = slots.made
        part = made.part
        memory = nnf.pad(z, (0, 0, 1, 1)).gather(1, part[..., None].expand(-1, -1, z.shape[-1]))
        queries = layered(self.positions, slots.lengths[:, 1])
        later = torch.triu(torch.ones(SLOTS, SLOTS, dtype=torch.bool), 1)
        x = self.decoder(
            queries, memory, tgt_mask=later, tgt_key_padding_mask=part == 3, memory_key_padding_mask=part == 3
        )
        return self.post_conv(x)


class OfficialMACVAE(nn.Module):
    """All networks of the release, under its names."""

    def __init__(self, width: int, heads: int, inner: int, layers: tuple[int, int], labels: int) -> None:
        super().__init__()
        self.priornet = Prior(width, labels)
        self.encoder = Encoder(width, heads, inner, layers[0], labels)
        self.decoder = Decoder(width, heads, inner, layers[1])
        self.postprocessor = Convolution(_ROT6D + _PLACE, _ROT6D + _PLACE, 2)

    def whole(self, rows: Tensor, place: Tensor, decoded: Tensor, slots: Slots) -> Tensor:
        """(B, 120, 315) what the postprocessor is given: the previous motion, then what was decoded, then a filling.

        Args:
            rows: (B, 120, 312) 6-D of the motion as rows; its first part is taken.
            place: (B, 120, 3) likewise.
            decoded: (B, 120, 315).
            slots: of the batch.
        """
        at, total = torch.arange(SLOTS), slots.lengths.sum(1, keepdim=True)
        source = torch.where(at < total, at - slots.lengths[:, :1], total - 1).clamp_min(0)
        later = decoded.gather(1, source[..., None].expand(-1, -1, decoded.shape[-1]))
        return torch.where((slots.part == 0)[..., None], torch.cat([rows, place], dim=-1), later)

    def forward(self, rows: Tensor, place: Tensor, z: Tensor, slots: Slots) -> Tensor:
        """(B, 120, 315) all slots, from latents (B, 2, H)."""
        return self.postprocessor(self.whole(rows, place, self.decoder(z, slots), slots))


def read(made: Tensor) -> tuple[Tensor, Tensor]:
    """What the networks give (..., 315) as rotations (..., 52, 3, 3) and places (..., 3)."""
    slopes = made[..., :_ROT6D].unflatten(-1, (JOINTS, 3, 2))
    return roma.special_gramschmidt(slopes), made[..., _ROT6D:]


@dataclass(frozen=True)
class Moved:
    """A motion as the release compares it."""

    pose: Tensor
    """(B, 120, 159) axis-angle and place."""
    vertices: Tensor
    """(B, 120, V, 3) of SMPL-H."""
    joints: Tensor
    """(B, 120, 52, 3)."""


def losses(made: Moved, real: Moved, posterior: Gaussian, prior: Gaussian, slots: Slots) -> dict[str, Tensor]:
    """The release's terms, weighted by 1, 1, 1 and 1e-5."""
    there = (slots.part < 3).float()[..., None]
    acceleration = made.joints[:, 2:] - 2 * made.joints[:, 1:-1] + made.joints[:, :-2]
    return {
        "pose": ((made.pose - real.pose).abs() * there).mean(),
        "mesh": ((made.vertices - real.vertices).abs() * there[..., None]).mean(),
        "acceleration": (acceleration.square() * there[:, 2:, :, None]).mean(),
        "kl": 1e-5 * divergence(posterior, prior).sum() / _BATCH,
    }


def build(state: dict[str, Tensor], heads: int = 4) -> OfficialMACVAE:
    """The networks of the release's weights, whose sizes they tell; heads they do not.

    Raises:
        CheckpointError: a weight is missing or of another shape.
    """
    ours = {name.removeprefix("module.").replace("layer.conv1.", ""): value.float() for name, value in state.items()}
    ours.pop("decoder.pos_enc.pe", None)
    ours.pop("encoder.pos_enc.pe", None)
    try:
        labels, width = ours["encoder.action_embed.weight"].shape
        inner = ours["decoder.decoder.layers.0.linear1.weight"].shape[0]
        layers = [len({name.split(".")[3] for name in ours if name.startswith(f"{part}.{part}.layers.")})
                  for part in ("encoder", "decoder")]  # fmt: skip
        model = OfficialMACVAE(width, heads, inner, (layers[0], layers[1]), labels)
        ours["priornet.bn.num_batches_tracked"] = torch.tensor(0)
        ours["encoder.bn.num_batches_tracked"] = torch.tensor(0)
        model.load_state_dict(ours)
    except (KeyError, ValueError, RuntimeError, AssertionError) as error:
        reason = " ".join(str(error).split())[:300]
        raise CheckpointError(f"these are not the weights of MultiAct's MACVAE: {reason}") from error
    return model.eval()
