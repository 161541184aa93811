"""The library: how long a step takes until it is saved, a draw, the opening of a large project, a search.

python benchmarks/library.py [--takes 1000]
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from studio.library import open_library
from studio.settings import GenerateSettings
from studio.takes import TakeList
from tests.studio.fakes import METRICS, sway


def milliseconds(act: Callable[[], object], times: int = 20) -> float:
    """Median of some runs."""
    spent = []
    for _ in range(times):
        began = time.perf_counter()
        act()
        spent.append(time.perf_counter() - began)
    return 1e3 * statistics.median(spent)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--takes", type=int, default=1000, help="in the large project")
    many = parser.parse_args().takes
    with tempfile.TemporaryDirectory() as folder:
        library = open_library(str(Path(folder) / "library.db"))
        key = library.create("Large")
        takes = TakeList(library.shelf(key))
        asked = GenerateSettings(engine="loom", count=4)
        for seed in range(many // 4):
            held = library.hold([sway(frames=60, seed=seed, index=i) for i in range(4)])
            takes.add(held, group=f"g{seed}", settings=asked, metrics=[METRICS] * 4)
        small = TakeList(library.shelf(library.create("Small")))
        draw = [sway(frames=60, seed=10**6 + i) for i in range(4)]
        small.add(library.hold(draw), group="g", settings=asked, metrics=[METRICS] * 4)
        marks = iter(range(10**6))
        fresh = iter(range(2 * 10**6, 3 * 10**6))
        rows = {
            "a step saved, small project": milliseconds(lambda: small.mark("take-1", tags=(f"t{next(marks)}",))),
            f"a step saved, {many:,} takes": milliseconds(lambda: takes.mark("take-1", tags=(f"t{next(marks)}",))),
            "four motions of 3 s put in (a worker's thread)": milliseconds(
                lambda: library.hold([sway(frames=60, seed=next(fresh)) for _ in range(4)])
            ),
            f"a project of {many:,} takes opened": milliseconds(lambda: library.shelf(key), 5),
            "nothing new seen (every 2 s a page)": milliseconds(takes.store.refresh),
            "a search over all takes": milliseconds(lambda: library.search("walk tag:t1")),
        }
        size = (Path(folder) / "library.db").stat().st_size
        for what, spent in rows.items():
            print(f"{what:<50}{spent:8.1f} ms")
        print(f"{'file, a take':<50}{size / many / 1e3:8.1f} kB")
        library.close()


if __name__ == "__main__":
    main()
