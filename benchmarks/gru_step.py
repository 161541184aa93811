"""Ways to run a GRU stack frame by frame, compared in one run.

    python benchmarks/gru_step.py [--threads 1 2] [--hidden 128 256] [--batch 1 128 300] [--frames 60] [--train] [--cpu]

The network is Action2Motion's generator (embedding, two GRU layers, linear head of 72 outputs) at 42 known inputs a
frame. Every way but the first feeds its own output back, so each frame waits for the one before. Milliseconds for the
whole sequence, best of the repeats, which are interleaved so that a busy machine slows all ways alike.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import torch
from torch import Tensor, nn
from torch.nn.functional import linear

from engines.action2motion.networks import GeneratorGRU, PlainHead

POSE, KNOWN, LAYERS = 72, 42, 2


def fused_teacher_forced(net: GeneratorGRU, head: nn.Module, known: Tensor, first: Tensor) -> Tensor:
    """Not self-fed: the lower bound when all inputs are known."""
    poses = first.expand(len(known), *first.shape)
    return head(net(torch.cat([poses, known], dim=-1))[0])


def gru_module_per_step(net: GeneratorGRU, head: nn.Module, known: Tensor, first: Tensor) -> Tensor:
    """nn.GRU called with one frame at a time."""
    pose, state, out = first, None, []
    for frame in known.unbind(0):
        hidden, state = net.gru(net.embed(torch.cat([pose, frame], dim=-1))[None], state)
        pose = head(hidden[0])
        out.append(pose)
    return torch.stack(out)


def cell_per_step(net: GeneratorGRU, head: nn.Module, known: Tensor, first: Tensor) -> Tensor:
    """torch.gru_cell on nn.GRU's parameters, inputs concatenated."""
    pose, state, out = first, None, []
    weights = net.gru.all_weights
    state = [first.new_zeros(len(first), net.hidden_size)] * net.layers
    for frame in known.unbind(0):
        value, new = net.embed(torch.cat([pose, frame], dim=-1)), []
        for layer, before in zip(weights, state, strict=True):
            value = torch.gru_cell(value, before, *layer)
            new.append(value)
        state = new
        pose = head(value)
        out.append(pose)
    return torch.stack(out)


def cell_known_ahead(net: GeneratorGRU, head: nn.Module, known: Tensor, first: Tensor) -> Tensor:
    """torch.gru_cell; the embedding of all that is known ahead is one product for the whole sequence."""
    pose_weight, known_weight = net.embed.weight.split([POSE, KNOWN], dim=1)
    ahead = linear(known, known_weight, net.embed.bias)
    weights = net.gru.all_weights
    pose, out, turned = first, [], pose_weight.t()
    state = [first.new_zeros(len(first), net.hidden_size)] * net.layers
    for frame in ahead.unbind(0):
        value, new = torch.addmm(frame, pose, turned), []
        for layer, before in zip(weights, state, strict=True):
            value = torch.gru_cell(value, before, *layer)
            new.append(value)
        state = new
        pose = head(value)
        out.append(pose)
    return torch.stack(out)


def cell_folded(net: GeneratorGRU, head: nn.Module, known: Tensor, first: Tensor) -> Tensor:
    """torch.gru_cell; embedding and first input weights multiplied together beforehand."""
    weight_ih, weight_hh, bias_ih, bias_hh = net.gru.all_weights[0]
    folded = [weight_ih @ net.embed.weight, weight_hh, torch.addmv(bias_ih, weight_ih, net.embed.bias), bias_hh]
    weights = [folded, *net.gru.all_weights[1:]]
    pose, out = first, []
    state = [first.new_zeros(len(first), net.hidden_size)] * net.layers
    for frame in known.unbind(0):
        value, new = torch.cat([pose, frame], dim=-1), []
        for layer, before in zip(weights, state, strict=True):
            value = torch.gru_cell(value, before, *layer)
            new.append(value)
        state = new
        pose = head(value)
        out.append(pose)
    return torch.stack(out)


def unroll(net: GeneratorGRU, head: nn.Module, known: Tensor, first: Tensor) -> Tensor:
    """What the engine does."""
    return net.unroll(known, first, head)[1]


def _fold(net: GeneratorGRU, known: Tensor) -> tuple[Tensor, Tensor]:
    """Embedding and first input weights multiplied together: gates known ahead (T, B, 3H), pose weights (Dp, 3H)."""
    weight_ih, _, bias_ih, _ = net.gru.all_weights[0]
    folded = weight_ih @ net.embed.weight
    bias = torch.addmv(bias_ih, weight_ih, net.embed.bias)
    return linear(known, folded[:, POSE:], bias), folded[:, :POSE].t()


def _gates(gi: Tensor, gh: Tensor, before: Tensor) -> Tensor:
    size = before.shape[1]
    gate = torch.sigmoid(gi[:, : 2 * size] + gh[:, : 2 * size])
    new = torch.tanh(torch.addcmul(gi[:, 2 * size :], gate[:, :size], gh[:, 2 * size :]))
    return torch.lerp(new, before, gate[:, size:])


def by_hand_folded(net: GeneratorGRU, head: nn.Module, known: Tensor, first: Tensor) -> Tensor:
    """Gates written out; embedding folded into the first input weights, known part one product."""
    ahead, pose_weight = _fold(net, known)
    state = [first.new_zeros(len(first), net.hidden_size)] * net.layers
    turned = [(w_ih.t(), w_hh.t(), b_ih, b_hh) for w_ih, w_hh, b_ih, b_hh in net.gru.all_weights]
    pose, out = first, []
    for frame in ahead.unbind(0):
        gi, new = torch.addmm(frame, pose, pose_weight), []
        for i, (before, (_, w_hh, _, b_hh)) in enumerate(zip(state, turned, strict=True)):
            if i:
                gi = torch.addmm(turned[i][2], new[-1], turned[i][0])
            new.append(_gates(gi, torch.addmm(b_hh, before, w_hh), before))
        state = new
        pose = head(state[-1])
        out.append(pose)
    return torch.stack(out)


@torch.jit.script
def _scripted_cells(
    ahead: Tensor, first: Tensor, pose_weight: Tensor, weights: list[list[Tensor]], head: list[Tensor]
) -> Tensor:
    hidden = weights[0][1].size(1)
    state = [torch.zeros(first.size(0), hidden) for _ in weights]
    pose, out = first, []
    for t in range(ahead.size(0)):
        value = torch.addmm(ahead[t], pose, pose_weight)
        for i in range(len(weights)):
            w = weights[i]
            value = torch.gru_cell(value, state[i], w[0], w[1], w[2], w[3])
            state[i] = value
        pose = torch.addmm(head[1], value, head[0])
        out.append(pose)
    return torch.stack(out)


def scripted_cells(net: GeneratorGRU, head: PlainHead, known: Tensor, first: Tensor) -> Tensor:
    """The loop of `cell_known_ahead` under torch.jit.script (a fixed linear head)."""
    pose_weight, known_weight = net.embed.weight.split([POSE, KNOWN], dim=1)
    ahead = linear(known, known_weight, net.embed.bias)
    weights = [list(layer) for layer in net.gru.all_weights]
    return _scripted_cells(ahead, first, pose_weight.t(), weights, [head.output.weight.t(), head.output.bias])


@torch.jit.script
def _scripted_folded(
    ahead: Tensor, first: Tensor, pose_weight: Tensor, weights: list[list[Tensor]], head: list[Tensor]
) -> Tensor:
    size = weights[0][1].size(1)
    state = [torch.zeros(first.size(0), size) for _ in weights]
    pose, out = first, []
    for t in range(ahead.size(0)):
        gi = torch.addmm(ahead[t], pose, pose_weight)
        for i in range(len(weights)):
            w = weights[i]
            if i > 0:
                gi = torch.addmm(w[2], state[i - 1], w[0].t())
            gh = torch.addmm(w[3], state[i], w[1].t())
            gate = torch.sigmoid(gi[:, : 2 * size] + gh[:, : 2 * size])
            new = torch.tanh(torch.addcmul(gi[:, 2 * size :], gate[:, :size], gh[:, 2 * size :]))
            state[i] = torch.lerp(new, state[i], gate[:, size:])
        pose = torch.addmm(head[1], state[-1], head[0])
        out.append(pose)
    return torch.stack(out)


def scripted_folded(net: GeneratorGRU, head: PlainHead, known: Tensor, first: Tensor) -> Tensor:
    """The loop of `by_hand_folded` under torch.jit.script (a fixed linear head)."""
    ahead, pose_weight = _fold(net, known)
    weights = [list(layer) for layer in net.gru.all_weights]
    return _scripted_folded(ahead, first, pose_weight, weights, [head.output.weight.t(), head.output.bias])


WAYS: tuple[Callable[..., Tensor], ...] = (
    fused_teacher_forced, gru_module_per_step, cell_per_step, cell_known_ahead, cell_folded, unroll, by_hand_folded,
    scripted_cells, scripted_folded,
)  # fmt: skip


def measure(hidden: int, batch: int, frames: int, args: argparse.Namespace) -> dict[str, float]:
    """Best milliseconds of each way; self-fed ways are first checked against each other."""
    torch.manual_seed(0)
    net, head = GeneratorGRU(POSE + KNOWN, hidden, LAYERS), PlainHead(hidden, POSE)
    known, first = torch.randn(frames, batch, KNOWN), torch.zeros(batch, POSE)
    target = torch.randn(frames, batch, POSE)
    parameters = [*net.parameters(), *head.parameters()]
    clock = time.process_time if args.cpu else time.perf_counter

    def once(way: Callable[..., Tensor]) -> float:
        start = clock()
        if args.train:
            loss = (way(net, head, known, first) - target).square().mean()
            torch.autograd.grad(loss, parameters)
        else:
            with torch.inference_mode():
                way(net, head, known, first)
        return (clock() - start) * 1e3

    with torch.no_grad():
        outputs = [way(net, head, known, first) for way in WAYS[1:]]
    for way, output in zip(WAYS[1:], outputs, strict=True):
        torch.testing.assert_close(
            output, outputs[0], atol=1e-5, rtol=1e-4, msg=f"{way.__name__} computes another thing"
        )
    best = {way.__name__: float("inf") for way in WAYS}
    for _ in range(args.repeats + 2):  # the first two let the profiling executor of jit settle
        for way in WAYS:
            best[way.__name__] = min(best[way.__name__], once(way))
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--hidden", type=int, nargs="+", default=[128, 256])
    parser.add_argument("--batch", type=int, nargs="+", default=[1, 128, 300])
    parser.add_argument("--frames", type=int, nargs="+", default=[60])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--train", action="store_true", help="forward and backward instead of inference")
    parser.add_argument("--cpu", action="store_true", help="CPU time: for one thread on a machine others are using")
    args = parser.parse_args()
    names = [way.__name__ for way in WAYS]
    print("forward and backward" if args.train else "inference", "- milliseconds for the whole sequence")
    print(f"{'threads hidden batch frames':>27}  " + "  ".join(f"{n:>{max(len(n), 8)}}" for n in names))
    for threads in args.threads:
        torch.set_num_threads(threads)
        for hidden in args.hidden:
            for batch in args.batch:
                for frames in args.frames:
                    best = measure(hidden, batch, frames, args)
                    row = "  ".join(f"{best[n]:>{max(len(n), 8)}.2f}" for n in names)
                    print(f"{threads:>7} {hidden:>6} {batch:>5} {frames:>6}  {row}", flush=True)


if __name__ == "__main__":
    main()
