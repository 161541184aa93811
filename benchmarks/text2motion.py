"""Text2Motion at the paper's sizes and at those that ship, random weights: milliseconds, ratios within one run.

python benchmarks/text2motion.py [paper|small] [threads]
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import torch

from engines.text.tags import SIDES, TAGS
from engines.text2motion import config, output
from engines.text2motion.model import Text2Motion, generate
from engines.text2motion.packed import PackedVAE
from engines.text2motion.words import WordBatch

FRAMES, WORDS, REPEATS = 196, 12, 9


def times(work: Callable[[], object]) -> tuple[float, float]:
    """Milliseconds: median and least."""
    work()
    taken = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        taken.append(1000 * (time.perf_counter() - began))
    return statistics.median(taken), min(taken)


def main() -> None:
    """Print the table."""
    name = sys.argv[1] if len(sys.argv) > 1 else "paper"
    if len(sys.argv) > 2:
        torch.set_num_threads(int(sys.argv[2]))
    torch.manual_seed(0)
    model = Text2Motion(config.preset(name).replaced(parts=config.STAGES)).eval().requires_grad_(False)
    net = model.text2motion
    assert net is not None
    packed = PackedVAE(net)
    codes = FRAMES // model.config.frames_a_code
    print(f"preset {name}, {torch.get_num_threads()} threads, motions of {FRAMES} frames")
    for count in (1, 32):
        vectors = torch.randn(count, WORDS, model.config.text_size)
        marks = torch.eye(len(TAGS) + len(SIDES))[torch.randint(len(TAGS), (count, WORDS))]
        words = WordBatch(vectors, marks, torch.full((count,), WORDS))
        many, start = torch.full((count,), codes), model.start(count)
        noise = torch.randn(count, codes, net.sizes.latent)
        made = generate(packed.steps(model.read(words), many, codes), start, noise)

        def stepwise(w=words, m=many, s=start, n=noise) -> torch.Tensor:
            return model.decode(generate(net.steps(model.read(w), m), s, n))

        def premultiplied(w=words, m=many, s=start, n=noise) -> torch.Tensor:
            return model.decode(generate(packed.steps(model.read(w), m, codes), s, n), m)

        rows = {
            "words to features, every step in full": stepwise,
            "words to features, packed": premultiplied,
            "features of codes": lambda c=made, m=many: model.decode(c, m),
            "Motions of codes": lambda c=made, m=many: output.to_motions(c, m, model, [FRAMES] * len(c)),
            "lengths": lambda w=words: model.length_logits(w),
        }
        with torch.inference_mode():
            first, least = times(stepwise)
            for label, work in rows.items():
                median, best = times(work)
                ratio = f"{first / median:6.2f} x {least / best:6.2f} x" if "features," in label else ""
                print(f"{count:>3} {label:<40} {median:9.1f} ms (least {best:8.1f})   {ratio}")


if __name__ == "__main__":
    main()
