"""Action2Motion: how fast it generates and trains, against a plain frame-by-frame program in the same run.

    python benchmarks/action2motion.py [--threads 2] [--repeats 7] [--quick]
    python benchmarks/action2motion.py --training [--threads 2] [--repeats 5]

Generation: our engine with the weights that ship, from an action's name to finished Motions (60 frames at 20 fps);
then the released network at the paper's sizes (random weights) run by `official.OfficialModel` and by a plain loop
that calls one cell after another and turns one joint after another. Beside them stand the released code's own times
from `golden/reference-times.json` of the shared folder, where there is one: another run, so a scale, no more.

Training: one step (losses, gradients, Adam, moving average) of the presets, batch 128, on random numbers of the right
sizes, against the same model stepped one GRU cell, one frame and one joint after another, both checked to lose the
same. Ways take turns; medians of wall and of processor time, the steadier one on a machine that others use.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
import torch
from official_action2motion import CASES, PlainWay, model, reference_times
from roma import rotvec_to_rotmat
from torch import Tensor
from torch.nn.functional import one_hot

import engines
from engines.action2motion.config import PAPER, SMALL, Action2MotionConfig
from engines.action2motion.losses import Batch, losses
from engines.action2motion.model import Action2Motion
from engines.action2motion.networks import EmbeddedGRU
from engines.action2motion.representation import local_positions
from engines.action2motion.train import FEET
from engines.skeletons import SMPL22
from engines.training.loop import TrainingPlan, TrainingState, train

Times = dict[str, tuple[float, float]]


def medians(ways: Mapping[str, Callable[[], object]], repeats: int) -> Times:
    """Wall and processor milliseconds of ways that take turns, after one round to warm up."""
    spent: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    for turn in range(repeats + 1):
        for name, way in ways.items():
            wall, cpu = time.perf_counter(), time.process_time()
            way()
            took = (time.perf_counter() - wall) * 1e3, (time.process_time() - cpu) * 1e3
            if turn:
                spent[name].append(took)
    return {name: tuple(statistics.median(part) for part in zip(*rows, strict=True)) for name, rows in spent.items()}


# ---- generation -----------------------------------------------------------------------------------------------


def generation(repeats: int, quick: bool) -> None:
    released = reference_times()
    print(f"{'our engine, weights that ship':<40}{'wall ms':>9}{'cpu ms':>9}{'released wall ms':>18}")
    ours = engines.load("action2motion")
    ways = {
        "load": lambda: engines.load("action2motion"),
        "1 motion of 60 frames": lambda: ours.generate("walk", frames=60, seed=1),
        "300 motions of 60 frames": lambda: ours.generate_many("walk", count=300, frames=60, seed=1),
    }
    theirs = {
        "1 motion of 60 frames": "a2m_lie_single_motion_60",
        "300 motions of 60 frames": "a2m_lie_300x60_one_batch",
    }
    for name, (wall, cpu) in medians(ways, repeats).items():
        print(f"{name:<40}{wall:>9.1f}{cpu:>9.1f}{_stated(released.get(theirs.get(name, ''))):>18}", flush=True)
    header = f"{'wall ms':>9}{'plain':>9}{'ratio':>7}{'cpu ms':>9}{'plain':>9}{'ratio':>7}{'released':>10}"
    title = "released network, the paper's sizes"
    print(f"\n{title:<40}{header}")
    for name, (lie, count) in CASES.items():
        if quick and count > 1:
            continue
        network = model(lie)
        plain = PlainWay(network)
        labels, noise = [i % 12 for i in range(count)], network.noise(count, 60, seed=0)
        torch.testing.assert_close(network.sample(labels, noise).joints, plain.sample(labels, noise), atol=1e-4, rtol=0)
        made = medians(
            {
                "ours": lambda w=network, a=labels, n=noise: w.sample(a, n),
                "plain": lambda w=plain, a=labels, n=noise: w.sample(a, n),
            },
            repeats,
        )
        print(f"{name:<40}{_row(made)}{_stated(released.get(name)):>10}", flush=True)


def _stated(milliseconds: float | None) -> str:
    return "" if milliseconds is None else f"{milliseconds:.1f}"


def _row(made: Times) -> str:
    ours, plain = made["ours"], made["plain"]
    return "".join(f"{a:>9.1f}{b:>9.1f}{b / a:>7.1f}" for a, b in zip(ours, plain, strict=True))


# ---- training -------------------------------------------------------------------------------------------------


class PlainModel(Action2Motion):
    """The same parameters in a straightforward program: one GRU cell, one frame, one joint after another."""

    def __init__(self, config: Action2MotionConfig) -> None:
        super().__init__(config)
        for network in (self.prior, self.posterior, self.generator):
            network.hidden_sequence = partial(_one_after_another, network)

    def joints(self, vectors: Tensor) -> tuple[Tensor, Tensor | None]:
        """As `Action2Motion.joints`."""
        made = [_turn_joint_by_joint(frame) for frame in vectors.unbind(0)]
        return torch.stack([p for p, _ in made]), torch.stack([m for _, m in made])


def _one_after_another(network: EmbeddedGRU, x: Tensor, state: Sequence[Tensor] | None = None):
    hidden = []
    for frame in x.unbind(0):
        state = network.hidden_step(frame, state)
        hidden.append(state[-1])
    return torch.stack(hidden), state


def _turn_joint_by_joint(vectors: Tensor) -> tuple[Tensor, Tensor]:
    local = [rotvec_to_rotmat(vectors[:, 1 + 3 * joint : 4 + 3 * joint]) for joint in range(len(SMPL22))]
    root = torch.nn.functional.pad(vectors[:, :1], (1, 1))
    world, places = [local[0]], [root + root.new_tensor(SMPL22.offsets[0])]
    for joint in range(1, len(SMPL22)):
        above = SMPL22.parents[joint]
        world.append(world[above] @ local[joint])
        places.append(places[above] + world[above] @ root.new_tensor(SMPL22.offsets[joint]))
    return torch.stack(places, dim=1), torch.stack(local, dim=1)


def random_batch(config: Action2MotionConfig) -> Batch:
    """Numbers of the right sizes: what they are does not change how long a step takes."""
    generator = torch.Generator().manual_seed(1)
    frames, count = config.window, config.batch_size

    def draw(*shape: int) -> Tensor:
        return 0.3 * torch.randn(frames, count, *shape, generator=generator)

    hot = one_hot(torch.arange(count) % len(config.actions), len(config.actions)).float().expand(frames, -1, -1)
    time_counter = torch.linspace(0, 1, frames)[:, None, None].expand(-1, count, 1)
    vectors = draw(config.pose_size)
    positions, matrices = local_positions(vectors[..., :1], vectors[..., 1:].unflatten(-1, (config.joints, 3)))
    contacts = (draw(4) > 0).float()
    conditions = torch.cat([hot, time_counter], dim=-1)
    return Batch(vectors, conditions, positions, matrices, draw(3), contacts, torch.ones(frames, count))


def stepper(kind: type[Action2Motion], config: Action2MotionConfig, batch: Batch) -> Callable[[], object]:
    """One training step of a new model, by the loop that trains."""
    torch.manual_seed(0)
    plan = TrainingPlan(steps=0, learning_rate=1e-4, final_learning_rate=1e-4, log_every=10**9)
    state = TrainingState(kind(config), plan)

    def step() -> object:
        state.plan = TrainingPlan(**{**vars(plan), "steps": state.step + 1})
        return train(state, lambda now: losses(now.model, batch, now.step, FEET, now.generator))

    return step


def training(repeats: int) -> None:
    titles = f"{'ours':>9}{'plain':>9}{'ratio':>7}"
    print(f"{'one step, ms':<40}{titles}{titles}{'steps/s':>9}")
    print(f"{'':<40}{'wall':>16}{'':>9}{'cpu':>16}")
    actions = engines.load("action2motion").config.actions
    for name, preset in {"small": SMALL, "paper": PAPER}.items():
        config = preset.replaced(actions=actions, nominal_frames=(20,) * len(actions), steps=10**6)
        batch = random_batch(config)
        _check_same(config, batch)
        made = medians(
            {"ours": stepper(Action2Motion, config, batch), "plain": stepper(PlainModel, config, batch)}, repeats
        )
        title = f"{name}: {config.window} frames, batch {config.batch_size}"
        print(f"{title:<40}{_row(made)}{1e3 / made['ours'][0]:>9.2f}", flush=True)


def _check_same(config: Action2MotionConfig, batch: Batch) -> None:
    made = []
    for kind in (Action2Motion, PlainModel):
        torch.manual_seed(0)
        with torch.no_grad():
            terms = losses(kind(config), batch, 0, FEET, torch.Generator().manual_seed(0))
        made.append({name: float(value) for name, value in terms.items()})
    np.testing.assert_allclose(list(made[0].values()), list(made[1].values()), rtol=1e-3)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--training", action="store_true")
    parser.add_argument("--quick", action="store_true", help="leave out the released network's batches of 300")
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    if args.training:
        training(args.repeats)
    else:
        generation(args.repeats, args.quick)


if __name__ == "__main__":
    main()
