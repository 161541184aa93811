"""`motionloom caption`: a motion file in words."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from engines.errors import CheckpointError


def caption(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Motion file: .bvh, .glb, .npz, .amc, .mat")],
    count: Annotated[int, typer.Option("--count", "-n", metavar="N", help="So many sentences at most, 1 to 16.")] = 3,
    beams: Annotated[int, typer.Option(metavar="N", help="Sentences that the search follows at a time, 1 to 16.")] = 2,
    checkpoint: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Weights of `motionloom train tm2t` in place of those shipped.")
    ] = None,
) -> None:
    """Say in words what a motion shows: sentences, the likeliest first.

    [bold]Examples[/bold]

    motionloom caption walk.bvh

    motionloom caption walk.bvh -n 5 --beams 8

    motionloom caption walk.bvh --checkpoint mine.safetensors

    Each line has a sentence; before it stands how well it fits the motion, from -1 to 1, where the evaluator's weights
    are there. Left and right, steps and turns are those of the motion itself.
    """
    import engines
    from studio import captions, quality

    engine = engines.load("tm2t", checkpoint=checkpoint) if checkpoint else captions.captioner()
    if engine is None:
        raise CheckpointError(
            "no engine that describes motions has weights here; give --checkpoint FILE "
            "(`motionloom train tm2t` makes one)."
        )
    motion = engines.read(file)
    found = engine.caption(motion, beams=beams, count=count)
    judge = captions.judge()
    if judge is None:
        lines = [said.sentence for said in found]
    else:
        fits = judge.similarity([said.sentence for said in found], [motion] * len(found))
        lines = [f"{quality.fit(value).text}  {said.sentence}" for value, said in zip(fits, found, strict=True)]
    for line in lines:
        typer.echo(line)
