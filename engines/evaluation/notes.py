"""How to read the table of an evaluation, a sentence or two at a time."""

from __future__ import annotations

from collections.abc import Sequence

from engines.evaluation.actions import COMPONENTS
from engines.evaluation.results import Results, Row
from engines.evaluation.rounds import PHYSICAL, REAL, TRAINING
from engines.evaluation.sequences import AROUND
from engines.metrics.protocol import ACTION2MOTION, STYLIZATION, TEXT2MOTION
from engines.metrics.retrieval import POOL


def notes(results: Results, rows: Sequence[Row]) -> list[str]:
    """What the figures of a protocol are."""
    most = max(len(row.repeats) for row in rows)
    fewer = [f"{row.name}: {len(row.repeats)}" for row in rows if len(row.repeats) < most]
    over = f"{most} repeat{'s' if most > 1 else ''}" + (f" ({', '.join(fewer)})" if fewer else "")
    said = {
        "action2motion": _of_actions,
        "text2motion": _of_texts,
        "stylization": _of_styles,
        "multiact": _of_sequences,
    }[results.basis.get("protocol", "action2motion")]
    made = said(results, f"Mean ± half width of the 95 % interval (Student's t) over {over}")
    if any("bone_length_drift" in row.repeats[0].figures for row in rows):
        made.append("Bone-length drift is that of the joints as the network gives them; motions themselves are rigid.")
    return made


def _of_actions(results: Results, mean: str) -> list[str]:
    basis = results.basis
    return [
        f"{mean} of {basis['motions']:,} motions of {basis['frames']} frames at 20 frames a second; "
        f"{len(results.actions)} actions in equal parts; seed {basis['seed']}.",
        "↑ higher is better, ↓ lower is better, → the closer to real motions of the training split the better. "
        "Bold: the best mean of the generated; a difference smaller than the intervals is none.",
        f"FID compares with held-out real clips (data: {basis['data']}), drawn with replacement, as many of each "
        "action. All rows meet the same draw in the same repeat. A clip longer than a generated motion gives a stretch "
        "of it, a shorter one counts as it is.",
        f"`{REAL}` is a second draw from the same clips: what real motion itself scores; its multimodality is low "
        f"where an action has few clips. `{TRAINING}` is drawn from the clips that engines and recogniser were trained "
        "on, so that its accuracy is no measure of the recogniser.",
        f"Accuracy counts over all {len(results.answers)} labels of the recogniser. Diversity: "
        f"{ACTION2MOTION.diversity_pairs} pairs; multimodality: {ACTION2MOTION.multimodality_pairs} pairs an action.",
        f"Physical measures: about {PHYSICAL} motions of each repeat, the first of every action. Per-action Fréchet "
        f"distances are taken in the first {COMPONENTS} principal components of the held-out clips' features: single "
        "actions have too few motions for all of them.",
    ]


def _of_texts(results: Results, mean: str) -> list[str]:
    basis = results.basis
    return [
        f"{mean} of {basis['motions']:,} sentences, each of another held-out clip (data: {basis['data']}), with one "
        f"motion as long as that clip; seed {basis['seed']}.",
        "↑ higher is better, ↓ lower is better, → the closer to held-out real motions the better. Bold: the best mean "
        "of the generated; a difference smaller than the intervals is none.",
        f"R-precision: the motion's own sentence is the nearest, among the 2, the 3 nearest of {POOL} in the space of "
        f"the co-embedding; no pool holds a sentence twice. By chance: {1 / POOL:.3f}, {2 / POOL:.3f}, {3 / POOL:.3f}. "
        "Many clips here show the same action, so sentences in a pool can be true of more than one motion, and real "
        "motion does not reach 1.",
        "The space has unit vectors: distances lie between 0 and 2, and FID, diversity and multimodality are as small. "
        "FID compares with held-out real clips drawn with replacement, the same draw for all rows of a repeat; "
        f"`{REAL}` are the real motions of the very sentences.",
        f"Diversity: {TEXT2MOTION.diversity_pairs} pairs. Multimodality: {basis['sentences with many']} sentences, "
        f"{TEXT2MOTION.motions_a_prompt} motions each, {TEXT2MOTION.multimodality_pairs} pairs a sentence; there "
        "is no real value to be near, and the papers count more as better. Physical measures: the first "
        f"{PHYSICAL} motions of each repeat.",
        "Sentences are captions from the grammar (and people's own), drawn with a seed that nothing was trained on; "
        "the grammar itself is that of the training captions.",
    ]


_TOLD = {
    "label": "a style's name",
    "motion": "a clip that has the style (and its name, where an engine was taught with names)",
    "prior": "no style, so that there is none to be recognised",
}


def _of_styles(results: Results, mean: str) -> list[str]:
    basis = results.basis
    said = [
        f"{mean} of {basis['motions']:,} held-out motions of {basis['corpus']} (data: {basis['data']}), each put in "
        f"one of {len(basis['styles'])} styles in equal parts; engines are given {_TOLD[basis['by']]}"
        f"{', and may make motions as fast as the style is' if basis['tempo'] else ''}; seed {basis['seed']}.",
        "↑ higher is better, ↓ lower is better, → the closer to real motions of the styles the better. Bold: the best "
        "mean of the generated; a difference smaller than the intervals is none.",
        f"Style accuracy and FID: the recogniser of styles, against the clips that give the styles. `{REAL}` are other "
        "held-out clips of the same styles.",
        "Geodesic distance: mean angle between the local rotations of a motion and of what was made of it. It is no "
        "quality by itself: 0 is a motion left as it was. Multimodality (the thesis's Div): "
        f"{STYLIZATION.multimodality_pairs} pairs a motion, of {STYLIZATION.motions_a_prompt} stylings.",
    ]
    if "content_accuracy" in {name for row in results.rows.values() for r in row.repeats for name in r.figures}:
        said.append("Content accuracy and FID: the recogniser of contents, against the motions as they were.")
    else:
        said.append("The recogniser of contents does not know what these motions show, so contents are not counted.")
    return said


def _of_sequences(results: Results, mean: str) -> list[str]:
    basis = results.basis
    return [
        f"{mean} of {basis['sequences']:,} sequences of {basis['steps']} actions, {basis['frames']} frames each at 20 "
        f"a second, the transition into it included; {len(basis['asked'])} actions, drawn at random, none twice in a "
        f"row; seed {basis['seed']}. Sequences and seeds are the same for all rows.",
        "↑ higher is better, ↓ lower is better, → the closer to real transitions the better. Bold: the best mean of "
        "the generated; a difference smaller than the intervals is none.",
        f"Transition FID looks at the transition and {AROUND} frames on both sides, as the recogniser of actions sees "
        "them; where there is no transition of its own (label switch), at the first half second of each new action.",
        f"The real transitions are made of held-out clips (data: {basis['data']}): {basis['captured']:.0%} were "
        "captured so, the others are two clips joined at their nearest poses and let in as the row `inertialised` "
        "does it, which that row may profit from.",
        f"Accuracy counts what follows the transition, over steps 2 to {basis['steps']}, over all "
        f"{len(results.answers)} labels of the recogniser; last quarter: over the last {basis['steps'] // 4} steps.",
        "Rows of action2motion: its clips, each by itself, turned and set behind each other, with half a second "
        "between them that is linear in 6-D and place, or a slerp; with the second let in over half a second "
        "(inertialised); or its own switch of the label. Row `loom, timeline`: as the studio's timeline makes them, "
        "each action by itself and half a second that Loom makes between the second before and the second after.",
    ]
