"""Sampling with an official Action2Motion model at the papers' sizes (random weights): ours against the plain way.

    python benchmarks/official_action2motion.py [--threads 2] [--repeats 15] [--cpu]

Hidden 128, latent 30, 1 / 1 / 2 layers, 24 joints, 60 frames; median milliseconds of repeats that take turns. The plain
way calls a GRUCell a layer and frame and turns one joint after another, frame by frame, as a straightforward program
would; it is checked to give the same motions. The released code's own times are read from
`golden/reference-times.json` of the shared folder where there is one: another run, so a scale, no more.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import time
from itertools import pairwise
from pathlib import Path

import torch
from torch import Tensor, nn

from engines.action2motion import official_lie
from engines.action2motion.networks import EmbeddedGRU
from engines.action2motion.official import OfficialConfig, OfficialModel, OfficialNetworks

FRAMES = 60
CASES = {
    "a2m_lie_single_motion_60": (True, 1),
    "a2m_lie_300x60_one_batch": (True, 300),
    "a2m_nolie_single_motion_60": (False, 1),
    "a2m_nolie_300x60_one_batch": (False, 300),
}


def reference_times() -> dict[str, float]:
    shared = Path(os.environ.get("MOTIONLOOM_SHARED", Path(__file__).resolve().parents[2] / "shared"))
    file = shared / "golden" / "reference-times.json"
    return {k: v["median_s"] * 1e3 for k, v in json.loads(file.read_text()).items()} if file.is_file() else {}


def model(lie: bool) -> OfficialModel:
    torch.manual_seed(0)
    sizes = OfficialConfig(
        joints=24, classes=12, latent_size=30, hidden_size=128, prior_layers=1, posterior_layers=1,
        generator_layers=2, lie=lie, time_counter=lie,
    )  # fmt: skip
    return OfficialModel(OfficialNetworks(sizes).eval())


def cells(network: EmbeddedGRU) -> list[nn.GRUCell]:
    """The layers of a network as modules of their own, with the same parameters."""
    made = []
    for weights in network.gru.all_weights:
        cell = nn.GRUCell(network.hidden_size, network.hidden_size)
        cell.weight_ih, cell.weight_hh, cell.bias_ih, cell.bias_hh = weights
        made.append(cell)
    return made


class PlainWay:
    """The same model, one thing after another."""

    def __init__(self, model: OfficialModel) -> None:
        self.model, self.networks = model, model.networks
        self.upper, self.lower = cells(model.networks.prior), cells(model.networks.generator)

    @torch.inference_mode()
    def sample(self, labels: list[int], noise: Tensor) -> Tensor:
        networks, config = self.networks, self.model.config
        upper = [torch.zeros(len(labels), config.hidden_size) for _ in self.upper]
        lower = [torch.zeros(len(labels), config.hidden_size) for _ in self.lower]
        pose, joints = torch.zeros(len(labels), 3 * config.joints), []
        for condition, eps in zip(self.model.condition(labels, len(noise)), noise, strict=True):
            value = networks.prior.embed(torch.cat([pose, condition], dim=1))
            for i, cell in enumerate(self.upper):
                value = upper[i] = cell(value, upper[i])
            mu, logvar = networks.prior.mu_net(value), networks.prior.logvar_net(value)
            z = mu + torch.exp(0.5 * logvar) * eps
            value = networks.generator.embed(torch.cat([pose, condition, z], dim=1))
            for i, cell in enumerate(self.lower):
                value = lower[i] = cell(value, lower[i])
            pose = networks.head(value)
            joints.append(self.joints(pose) if config.lie else pose.unflatten(-1, (config.joints, 3)))
        return torch.stack(joints, dim=1)

    def joints(self, pose: Tensor) -> Tensor:
        skeleton = self.model.skeleton
        slots = pose.unflatten(-1, (len(skeleton), 3))
        bones = skeleton.bone_translations(torch.tensor(skeleton.mean_lengths))
        places: list[Tensor] = [slots[:, 0]] * len(skeleton)
        for chain in skeleton.chains:
            turn = torch.eye(3).expand(len(pose), 3, 3)
            for parent, joint in pairwise(chain):
                turn = turn @ official_lie.exp(slots[:, joint])
                places[joint] = (turn @ bones[joint]) + places[parent]
        return torch.stack(places, dim=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--cpu", action="store_true", help="CPU time: for one thread on a machine others are using")
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    clock = time.process_time if args.cpu else time.perf_counter
    released = reference_times()
    print(f"{'':<28}{'ours ms':>9}{'plain ms':>10}{'ratio':>7}{'released ms':>13}")
    for name, (lie, count) in CASES.items():
        ours = model(lie)
        plain = PlainWay(ours)
        labels, noise = [i % 12 for i in range(count)], ours.noise(count, FRAMES, seed=0)
        torch.testing.assert_close(ours.sample(labels, noise).joints, plain.sample(labels, noise), atol=1e-4, rtol=0)
        times: dict[object, list[float]] = {ours: [], plain: []}
        for _ in range(args.repeats):
            for way, spent in times.items():
                start = clock()
                way.sample(labels, noise)
                spent.append((clock() - start) * 1e3)
        fast, slow = (statistics.median(spent) for spent in times.values())
        theirs = f"{released[name]:>13.1f}" if name in released else ""
        print(f"{name:<28}{fast:>9.2f}{slow:>10.2f}{slow / fast:>7.1f}{theirs}", flush=True)


if __name__ == "__main__":
    main()
