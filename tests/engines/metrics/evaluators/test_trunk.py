"""Motions in a row are seen as they are alone."""

from __future__ import annotations

import numpy as np
import torch

from engines.metrics.evaluators import trunk
from engines.skeletons import SMPL22
from tests.engines.action2motion.tiny import movement


def made() -> trunk.Trunk:
    torch.manual_seed(0)
    net = trunk.Trunk(16, 0.1)
    net.scale_to([trunk.describe(movement(50, seed=9))])
    for norm in net.norms:  # a fresh one leaves zeros zero, which would hide what crosses a gap
        torch.nn.init.normal_(norm.bias)
        torch.nn.init.normal_(norm.running_mean)
    return net.eval()


def test_one_behind_the_other_or_alone_is_the_same() -> None:
    net = made()
    rows = [trunk.describe(movement(length, seed=length)) for length in (17, 18, 19, 40, 61)]
    together = net.pooled_in_row(trunk.in_row(rows))
    padded = net.pooled(*trunk.pad(rows))[:, : together.shape[1]]  # without the deviation
    torch.testing.assert_close(together, padded, atol=1e-5, rtol=1e-5)
    for i, row in enumerate(rows):
        torch.testing.assert_close(together[i], net.pooled_in_row(trunk.in_row([row]))[0], atol=1e-5, rtol=1e-5)


def test_what_moves_about_its_mean_is_seen_beside_the_mean() -> None:
    net = made()
    row = trunk.describe(movement(40, seed=3))
    deviation = net.pooled(*trunk.pad([row, row[:20]]))[:, 32:]
    x, there = net._convolved(*trunk.pad([row, row[:20]]))
    for i, frames in enumerate(there[:, 0].sum(-1).int().tolist()):
        torch.testing.assert_close(deviation[i], (x[i, :, :frames].var(-1, correction=0) + 1e-4).sqrt())


def test_a_row_says_whose_frames_are_where() -> None:
    rows = [np.full((length, trunk.CHANNELS), float(length), dtype=np.float32) for length in (5, 8)]
    found = trunk.in_row(rows)
    assert found.count == 2
    for i, length in enumerate((5, 8)):
        assert (found.owner == i).sum() == length
        assert (found.frames[found.owner == i] == length).all()
    assert (found.frames[found.owner < 0] == 0).all()


def test_the_same_movement_faster_moves_faster() -> None:
    row = trunk.describe(movement(60, turning=0.2))
    faster = trunk.sampled(row, np.arange(0.0, 59, 1.25), 1.25)
    assert len(faster) == 48
    same = trunk.sampled(row, np.arange(60.0), 1.0)
    np.testing.assert_allclose(same, row, atol=1e-6)
    np.testing.assert_allclose(faster[8, :-3], trunk.sampled(row, np.array([10.0]), 1.25)[0, :-3])
    np.testing.assert_allclose(faster[8, -3:], 1.25 * row[10, -3:], rtol=1e-5)


def test_of_a_long_motion_the_middle_is_seen() -> None:
    motion = movement(70)
    np.testing.assert_allclose(trunk.describe(motion, 30)[1:], trunk.describe(motion)[21:50], atol=1e-6)


def test_a_single_frame_is_seen_too() -> None:
    row = trunk.describe(movement(20)[:1])
    assert row.shape == (1, trunk.CHANNELS)
    assert np.abs(row[:, trunk.BONES : 2 * trunk.BONES]).max() == 0.0
    assert torch.isfinite(made().pooled_in_row(trunk.in_row([row]))).all()


def test_hands_are_seen_beside_the_bones_and_turn_with_the_wrists() -> None:
    motion = movement(30, seed=4)
    plain, seen = trunk.describe(motion), trunk.describe(motion, hands=True)
    assert (seen[:, : trunk.CHANNELS] == plain).all()
    ways = seen[:, trunk.CHANNELS : trunk.CHANNELS + trunk.HANDS]
    np.testing.assert_allclose(np.linalg.norm(ways.reshape(30, 2, 3), axis=-1), 1.0, atol=1e-6)
    np.testing.assert_allclose(seen[1:, trunk.CHANNELS + trunk.HANDS :], np.diff(ways, axis=0), atol=1e-6)
    turns = np.array(motion.rotations)
    turns[:, SMPL22.index("left_wrist")] = [1.0, 0.0, 0.0, 0.0]  # in line with the forearm
    straight = trunk.describe(motion.replaced(rotations=turns), hands=True)
    forearm = SMPL22.index("left_wrist") - 1
    np.testing.assert_allclose(
        straight[:, trunk.CHANNELS : trunk.CHANNELS + 3], plain[:, 3 * forearm : 3 * forearm + 3], atol=1e-5
    )
    assert np.abs(ways - straight[:, trunk.CHANNELS : trunk.CHANNELS + trunk.HANDS])[:, :3].max() > 0.1
    mirrored = trunk.describe(motion.mirror(), hands=True)[:, trunk.CHANNELS : trunk.CHANNELS + trunk.HANDS]
    np.testing.assert_allclose(mirrored[:, 3:] * [-1, 1, 1], ways[:, :3], atol=1e-5)
