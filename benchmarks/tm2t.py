"""TM2T at the paper's sizes and at those that ship, random weights: milliseconds, medians, ratios within one run.

python benchmarks/tm2t.py [paper|small] [threads]
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import torch

from engines.text import EncodedText
from engines.tm2t import config
from engines.tm2t.model import TM2T
from engines.tm2t.packed import PackedGRU
from engines.tm2t.sampling import sample, uniforms
from engines.tm2t.search import beam_search

TOKENS, WORDS, REPEATS = 49, 12, 5


def median(work: Callable[[], object]) -> float:
    """Milliseconds."""
    work()
    taken = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        taken.append(1000 * (time.perf_counter() - began))
    return statistics.median(taken)


def main() -> None:
    """Print the table."""
    name = sys.argv[1] if len(sys.argv) > 1 else "paper"
    if len(sys.argv) > 2:
        torch.set_num_threads(int(sys.argv[2]))
    torch.manual_seed(0)
    words = tuple(f"word{place}" for place in range(600))
    model = TM2T(config.preset(name).replaced(words=words, parts=tuple(config.PARTS.values()))).eval()
    model.requires_grad_(False)
    net, back = model.text2motion, model.motion2text
    assert net is not None and back is not None and not isinstance(net, type(back))
    rows = []
    for count in (1, 64):
        told = EncodedText(torch.zeros(0), torch.randn(count, WORDS, model.config.text_size), torch.ones(0, 0).bool())
        read = net.read(told.tokens, torch.full((count,), WORDS))
        uniform = uniforms(0, range(count), TOKENS)
        for label, maker in (
            ("every step in full", net),
            ("packed", PackedGRU(net)),
            ("packed, bf16", PackedGRU(net, torch.bfloat16)),
        ):
            took = median(lambda m=maker, r=read, u=uniform: sample(m.steps(r), model.tokens, u, 100, exactly=TOKENS))
            rows.append((f"{count} x {TOKENS} tokens, {label}", took))
    codes = torch.randint(model.config.codes, (1, TOKENS))
    rows.append((f"decode 1 x {4 * TOKENS} frames", median(lambda: model.tokenizer.decode(codes))))
    tokens = model.tokens.rows([codes[0].numpy()])
    there = torch.ones_like(tokens, dtype=torch.bool)
    rows.append(
        (
            "caption, 2 beams, 30 words",
            median(lambda: beam_search(back.steps(back.read(tokens, there).repeated(2)), model.words, 1, 2, 30)),
        )
    )
    first = rows[0][1]
    print(f"preset {name}, {torch.get_num_threads()} threads")
    for label, took in rows:
        print(f"{label:<40} {took:9.1f} ms   {first / took:6.2f} x")


if __name__ == "__main__":
    main()
