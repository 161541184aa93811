"""How good a trained Loom is against real clips held out: the figures of its card.

The table beside the published engines is made by `motionloom evaluate`; here are the goals that no paper's table has.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from engines.datasets import Clip
from engines.evaluation import prompts
from engines.evaluation.prompts_more import MORE
from engines.loom.engine import LoomEngine
from engines.loom.passes import GUIDANCE
from engines.loom.representation import frames_of
from engines.metrics import distribution, evaluators, physical
from engines.motion import Motion

PHYSICAL = ("foot_skate", "jitter", "ground_penetration")
_SHAPE_FRAMES = 24
"""Frames to which motions are brought before their poses are compared."""


@dataclass(frozen=True)
class Assessment:
    """Shares from 0 to 1, metres and seconds; each beside the same of real clips held out."""

    accuracy: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Corpus -> motions recognised as the action asked for: generated, real."""
    styles: tuple[float, float] = (0.0, 0.0)
    """Recognised as the style asked for."""
    physics: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Mean over motions of the same actions: generated, real."""
    fid: tuple[float, float] = (0.0, 0.0)
    """To held-out clips, of as many generated motions and of training clips (the floor)."""
    multimodality: tuple[float, float] = (0.0, 0.0)
    """Mean distance of features of two motions of the same action."""
    nearest: tuple[float, float] = (0.0, 0.0)
    """Median distance, centimetres a joint, to the nearest training clip of the same action: generated, held out."""
    by_action: dict[str, float] = field(default_factory=dict)
    by_style: dict[str, float] = field(default_factory=dict)
    prompts: list[prompts.Answer] = field(default_factory=list)
    """Of the sixty."""
    more: list[prompts.Answer] = field(default_factory=list)
    """Of another writer's prompts."""
    held: tuple[str, ...] = ()
    """Actions that there are clips of which were not trained on."""


def assess(
    engine: LoomEngine, clips: Sequence[Clip], draws: int = 8, seed: int = 11, guidance: float = GUIDANCE
) -> Assessment:
    """All figures.

    Args:
        engine: to be judged.
        clips: of all splits.
        draws: motions an action, and half as many an action and style.
        seed: of the draws.
        guidance: of the sampler.
    """
    known = [clip for clip in clips if clip.action in engine.config.actions]
    train = [clip for clip in known if clip.split == "train"]
    held = [clip for clip in known if clip.split != "train"]
    recogniser = evaluators.load("action")
    made = {name: _drawn(engine, name, train, draws, seed, guidance) for name in engine.config.actions}
    seen = {name: recogniser.recognise(motions) for name, motions in made.items()}
    by_action = {name: float(np.mean([said == name for said in seen[name]])) for name in made}
    styled, by_style = _styles(engine, train, held, max(1, draws // 2), seed, guidance)
    both = [(name, motion) for name, motions in made.items() for motion in motions]
    both = [(name, motion) for name, motion in both if any(clip.action == name for clip in held)]

    def told(sentence: str, count: int) -> list[Motion]:
        return engine.generate_many(prompt=sentence, count=count, frames=80, seed=seed, guidance=guidance)

    return Assessment(
        accuracy=_accuracy(by_action, train, held, recogniser),
        styles=styled,
        physics=_physics(both, held),
        fid=_fid(both, train, held, recogniser, seed),
        multimodality=_multimodality(both, held, recogniser, seed),
        nearest=_nearest(both, train, held),
        by_action=by_action,
        by_style=by_style,
        prompts=prompts.answers(lambda sentence: told(sentence, 4), recogniser),
        more=prompts.answers(lambda sentence: told(sentence, 2), recogniser, MORE),
        held=tuple(sorted({clip.action for clip in held if clip.action})),
    )


def _drawn(  # noqa: PLR0913, PLR0917 - what is drawn
    engine: LoomEngine, action: str, train: Sequence[Clip], draws: int, seed: int, guidance: float
) -> list[Motion]:
    """Motions of an action, as long as its clips usually are."""
    _, usual, _ = engine.config.usual_frames[engine.config.actions.index(action)]
    return engine.generate_many(
        action, count=draws, frames=min(usual, engine.config.longest), seed=seed, guidance=guidance
    )


def _accuracy(
    by_action: Mapping[str, float], train: Sequence[Clip], held: Sequence[Clip], recogniser: evaluators.Recogniser
) -> dict[str, tuple[float, float]]:
    """Mean over a corpus's actions; of real clips, over clips."""
    found = {}
    for corpus in sorted({clip.corpus for clip in held}):
        names = sorted({clip.action for clip in train if clip.corpus == corpus and clip.action})
        real = [clip for clip in held if clip.corpus == corpus]
        said = recogniser.recognise([clip.motion for clip in real])
        right = float(np.mean([a == clip.action for a, clip in zip(said, real, strict=True)]))
        found[corpus] = (float(np.mean([by_action[name] for name in names])), right)
    return found


def _styles(  # noqa: PLR0913, PLR0917 - what is drawn and what it is compared with
    engine: LoomEngine, train: Sequence[Clip], held: Sequence[Clip], draws: int, seed: int, guidance: float
) -> tuple[tuple[float, float], dict[str, float]]:
    """Share recognised of every action in every style it was performed in, and of held-out clips; and by style."""
    recogniser = evaluators.load("style")
    pairs = sorted({(clip.action, clip.style) for clip in train if clip.action and clip.style in recogniser.labels})
    right: dict[str, list[bool]] = {}
    for action, style in pairs:
        assert action and style
        own = [len(clip.motion) for clip in train if (clip.action, clip.style) == (action, style)]
        frames = min(int(np.median(own)), engine.config.longest)
        motions = engine.generate_many(action, count=draws, frames=frames, seed=seed, style=style, guidance=guidance)
        right.setdefault(style, []).extend(said == style for said in recogniser.recognise(motions))
    real = [clip for clip in held if clip.style in recogniser.labels]
    said = recogniser.recognise([clip.motion for clip in real])
    of_real = float(np.mean([a == clip.style for a, clip in zip(said, real, strict=True)]))
    every = [hit for hits in right.values() for hit in hits]
    return (float(np.mean(every)), of_real), {style: float(np.mean(hits)) for style, hits in right.items()}


def _physics(made: Sequence[tuple[str, Motion]], held: Sequence[Clip]) -> dict[str, tuple[float, float]]:
    """Means over actions, so that both count the same ones alike."""
    ours, theirs = _by_name(made), _by_name([(clip.action or "", clip.motion) for clip in held])
    means = {}
    for key in PHYSICAL:
        values = [
            np.mean([np.mean([physical.summary(m)[key] for m in motions[:12]]) for motions in group.values()])
            for group in (ours, {name: theirs[name] for name in ours})
        ]
        means[key] = (float(values[0]), float(values[1]))
    return means


def _fid(
    made: Sequence[tuple[str, Motion]], train: Sequence[Clip], held: Sequence[Clip],
    recogniser: evaluators.Recogniser, seed: int,
) -> tuple[float, float]:  # fmt: skip
    """FID to held-out clips of generated motions, and of as many training clips, actions in the same proportions."""
    rng = np.random.default_rng(seed)
    real = _by_name([(clip.action or "", clip.motion) for clip in held])
    training = _by_name([(clip.action or "", clip.motion) for clip in train])
    names = [name for name, _ in made]
    pick = {key: recogniser.recognised([group[name][rng.integers(len(group[name]))] for name in names]).features
            for key, group in (("held", real), ("train", training))}  # fmt: skip
    ours = recogniser.recognised([motion for _, motion in made]).features
    return distribution.fid(pick["held"], ours), distribution.fid(pick["held"], pick["train"])


def _multimodality(
    made: Sequence[tuple[str, Motion]], held: Sequence[Clip], recogniser: evaluators.Recogniser, seed: int
) -> tuple[float, float]:
    """Of actions with several held-out clips."""
    found = []
    several = {name for name, group in _by_name([(c.action or "", c.motion) for c in held]).items() if len(group) > 1}
    for pairs in (list(made), [(clip.action or "", clip.motion) for clip in held]):
        kept = [(name, motion) for name, motion in pairs if name in several]
        names = sorted(several)
        features = recogniser.recognised([motion for _, motion in kept]).features
        labels = np.array([names.index(name) for name, _ in kept])
        found.append(distribution.multimodality(features, labels, seed=seed))
    return found[0], found[1]


def _nearest(made: Sequence[tuple[str, Motion]], train: Sequence[Clip], held: Sequence[Clip]) -> tuple[float, float]:
    """Median distance to the nearest training clip of the same action, centimetres a joint."""
    pool = {name: np.stack([_shape(m) for m in group]) for name, group in
            _by_name([(c.action or "", c.motion) for c in train]).items()}  # fmt: skip

    def gaps(pairs: Sequence[tuple[str, Motion]]) -> float:
        found = []
        for name, motion in pairs:
            near = np.linalg.norm(pool[name] - _shape(motion), axis=-1).mean((1, 2)).min()
            found.append(100 * near)
        return float(np.median(found))

    return gaps(made), gaps([(clip.action or "", clip.motion) for clip in held if clip.action in pool])


def _shape(motion: Motion) -> np.ndarray:
    """(F, J, 3) joints as seen from where the body stands and faces, at even parts of the motion."""
    joints = frames_of(motion).joints
    return joints[np.linspace(0, len(joints) - 1, _SHAPE_FRAMES).round().astype(int)]


def _by_name(pairs: Sequence[tuple[str, Motion]]) -> dict[str, list[Motion]]:
    groups: dict[str, list[Motion]] = {}
    for name, motion in pairs:
        groups.setdefault(name, []).append(motion)
    return groups
