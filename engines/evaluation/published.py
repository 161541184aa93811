"""Figures that the papers print, to stand beside ours: on other data, by other recognisers.

An FID is in the units of the features of its evaluator, so that none of these can be compared with ours as a number;
what can be is how rows of one table stand to each other. Sources: thesis, "3D human action modeling", tables 3.2 and
3.3; the rows `Real motions`, `plain` and `w/ Lie` on coarse HumanAct12, NTU-RGBD and (to two digits, one less) CMU are
also tables 1 and 2 of Guo et al. 2020, "Action2Motion", where they are called `Ours w/o Lie` and `Ours`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from engines.metrics.protocol import Estimate

WARNING = "published, on other data and with other evaluators: compare rows within a data set, never with ours"
COLUMNS = ("fid", "accuracy_top1", "diversity", "multimodality")


@dataclass(frozen=True)
class Published:
    """A row of a paper's table."""

    method: str
    data: str
    table: str
    figures: dict[str, Estimate]
    """By their names in `protocol.METRICS`."""


def _rows(data: str, table: str, lines: str) -> list[Published]:
    made = []
    for line in lines.strip().splitlines():
        method, *cells = (part.strip() for part in line.split("|"))
        pairs = [tuple(map(float, cell.split("±"))) for cell in cells]
        figures = {name: Estimate(mean, half) for name, (mean, half) in zip(COLUMNS, pairs, strict=True)}
        made.append(Published(method, data, table, figures))
    return made


ACTION2MOTION: Sequence[Published] = (
    *_rows("HumanAct12, 12 actions", "thesis, table 3.2", """
        Real motions           | 0.092 ± .007 | 0.997 ± .001 | 6.853 ± .053 | 2.449 ± .038
        Action2Motion (plain)  | 3.299 ± .079 | 0.656 ± .005 | 6.742 ± .046 | 4.248 ± .037
        Action2Motion (w/ Lie) | 2.458 ± .079 | 0.923 ± .002 | 7.032 ± .038 | 2.870 ± .037
        Action2Motion (GLMI-M) | 2.157 ± .052 | 0.835 ± .005 | 6.986 ± .028 | 3.633 ± .031
        Action2Motion (GLMI-R) | 2.349 ± .057 | 0.831 ± .002 | 7.001 ± .023 | 3.607 ± .037
    """),
    *_rows("HumanAct12, 34 actions", "thesis, table 3.2", """
        Real motions           | 0.133 ± .004 | 0.991 ± .001 | 7.001 ± .018 | 2.666 ± .012
        Action2Motion (plain)  | 1.329 ± .021 | 0.560 ± .002 | 6.756 ± .015 | 4.487 ± .015
        Action2Motion (w/ Lie) | 1.000 ± .016 | 0.776 ± .001 | 6.783 ± .015 | 3.508 ± .011
        Action2Motion (GLMI-M) | 0.739 ± .015 | 0.787 ± .002 | 6.783 ± .015 | 3.301 ± .009
        Action2Motion (GLMI-R) | 0.957 ± .017 | 0.767 ± .001 | 6.924 ± .019 | 3.303 ± .012
    """),
    *_rows("CMU MoCap", "thesis, table 3.3", """
        Real motions           | 0.064 ± .006 | 0.936 ± .002 | 6.130 ± .079 | 2.726 ± .066
        Action2Motion (plain)  | 2.994 ± .052 | 0.378 ± .004 | 5.791 ± .044 | 5.006 ± .045
        Action2Motion (w/ Lie) | 2.885 ± .116 | 0.686 ± .003 | 6.509 ± .061 | 4.126 ± .056
        Action2Motion (GLMI-M) | 2.448 ± .031 | 0.665 ± .001 | 6.374 ± .022 | 4.093 ± .019
        Action2Motion (GLMI-R) | 2.519 ± .029 | 0.675 ± .001 | 6.484 ± .028 | 4.073 ± .029
    """),
    *_rows("NTU-RGBD", "thesis, table 3.3", """
        Real motions           | 0.031 ± .004 | 0.999 ± .001 | 7.108 ± .048 | 2.194 ± .025
        Action2Motion (plain)  | 0.540 ± .047 | 0.832 ± .004 | 6.926 ± .049 | 3.443 ± .052
        Action2Motion (w/ Lie) | 0.330 ± .008 | 0.949 ± .001 | 7.065 ± .043 | 2.052 ± .030
    """),
)  # fmt: skip
"""The four decoders and the real motions they were compared with."""
