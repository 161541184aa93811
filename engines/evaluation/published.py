"""Figures that the papers print, to stand beside ours: on other data, by other recognisers.

An FID is in the units of the features of its evaluator, and R-precision depends on how alike the sentences of a data
set are, so that none of these can be compared with ours as a number; what can be is how rows of one table stand to each
other. Sources: thesis, "3D human action modeling", tables 3.2 and 3.3; the rows `Real motions`, `plain` and `w/ Lie` on
coarse HumanAct12, NTU-RGBD and (to two digits, one less) CMU are also tables 1 and 2 of Guo et al. 2020,
"Action2Motion", where they are called `Ours w/o Lie` and `Ours`. Text2Motion: Guo et al. 2022, tables 2 and 3, also the
thesis's 4.2 and 4.3; TM2T: thesis, table 6.2. Stylization: thesis, table 5.2. MultiAct: Lee et al. 2023, tables 2
and 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from engines.metrics.protocol import Estimate

WARNING = "published, on other data and with other evaluators: compare rows within a data set, never with ours"
COLUMNS = ("fid", "accuracy_top1", "diversity", "multimodality")
TEXT_COLUMNS = (
    "r_precision_top1", "r_precision_top2", "r_precision_top3", "fid", "multimodal_distance", "diversity",
    "multimodality",
)  # fmt: skip


@dataclass(frozen=True)
class Published:
    """A row of a paper's table."""

    method: str
    data: str
    table: str
    figures: dict[str, Estimate]
    """By their names in `protocol.METRICS`."""


@dataclass(frozen=True)
class Papers:
    """What stands below the table of a protocol."""

    title: str
    """Of the protocol."""
    columns: tuple[str, ...]
    rows: Sequence[Published]
    note: str
    """How to read the rows."""


def _rows(data: str, table: str, lines: str, columns: tuple[str, ...] = COLUMNS) -> list[Published]:
    made = []
    for line in lines.strip().splitlines():
        method, *cells = (part.strip() for part in line.split("|"))
        figures = {
            name: Estimate(float(cell.partition("±")[0]), float(cell.partition("±")[2]))
            for name, cell in zip(columns, cells, strict=True)
            if cell != "-"
        }
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

TEXT2MOTION: Sequence[Published] = (
    *_rows("HumanML3D", "Text2Motion, table 2", """
        Real motions                |.511±.003|.703±.003|.797±.002|.002±.000|2.974±.008|9.503±.065|-
        Text2Motion, real length    |.457±.002|.639±.003|.740±.003|1.067±.002|3.340±.008|9.188±.002|2.090±.083
        Text2Motion                 |.455±.003|.636±.003|.736±.002|1.087±.021|3.347±.008|9.175±.083|2.219±.074
    """, TEXT_COLUMNS),
    *_rows("HumanML3D", "thesis, table 6.2", """
        TM2T                        |.424±.003|.618±.003|.729±.002|1.501±.017|3.467±.011|8.589±.076|2.424±.093
    """, TEXT_COLUMNS),
    *_rows("KIT-ML", "Text2Motion, table 3", """
        Real motions                |.424±.005|.649±.006|.779±.006|.031±.004|2.788±.012|11.08±.097|-
        Text2Motion, real length    |.370±.005|.569±.007|.693±.007|2.770±.109|3.401±.008|10.91±.119|1.482±.065
        Text2Motion                 |.361±.006|.559±.007|.681±.007|3.022±.107|3.488±.028|10.72±.145|2.052±.107
    """, TEXT_COLUMNS),
    *_rows("KIT-ML", "thesis, table 6.2", """
        TM2T                        |.280±.005|.463±.006|.587±.005|3.599±.153|4.591±.026|9.473±.117|3.292±.081
    """, TEXT_COLUMNS),
)  # fmt: skip
"""Both text-to-motion systems and the real motions they were compared with."""

STYLE_COLUMNS = ("style_accuracy", "style_fid", "pose_distance", "multimodality")
STYLIZATION: Sequence[Published] = (
    *_rows("Aberman et al.", "thesis, table 5.2", """
        Real motions                              |.997±.002|.002±.000|-|-
        motion-based (S), Aberman et al.          |.547±.016|.379±.018|.804±.003|-
        motion-based (S), Park et al.             |.891±.007|.038±.003|.531±.001|-
        motion-based (S), the thesis, no latent   |.932±.008|.022±.002|.463±.003|-
        motion-based (S), the thesis (V)          |.935±.007|.020±.002|.426±.003|-
        motion-based (S), the thesis (A)          |.945±.007|.020±.002|.344±.002|-
        label-based (S), Park et al.              |.971±.006|.013±.001|.571±.002|.146±.009
        label-based (S), the thesis, no latent    |.933±.009|.023±.002|.447±.002|.174±.017
        label-based (S), the thesis (V)           |.946±.007|.020±.002|.427±.003|.134±.016
        label-based (S), the thesis (A)           |.942±.006|.019±.001|.344±.003|.050±.006
        motion-based (U), Jang et al.             |.833±.010|.047±.004|.559±.003|-
        motion-based (U), the thesis, no latent   |.780±.014|.048±.003|.466±.004|-
        motion-based (U), the thesis (V)          |.840±.010|.036±.003|.478±.004|-
        motion-based (U), the thesis (A)          |.804±.011|.040±.003|.441±.003|-
        prior-based (U), the thesis, no latent    |-|-|.431±.003|1.169±.030
        prior-based (U), the thesis (V)           |-|-|.418±.003|1.069±.028
        prior-based (U), the thesis (A)           |-|-|.436±.004|1.187±.029
    """, STYLE_COLUMNS),
    *_rows("CMU Mocap, unseen", "thesis, table 5.2", """
        motion-based (S), the thesis (V)          |.918±.010|.028±.003|.629±.002|-
        motion-based (S), the thesis (A)          |.918±.007|.031±.003|.569±.002|-
        label-based (S), the thesis (V)           |.923±.007|.027±.003|.614±.002|.193±.013
        label-based (S), the thesis (A)           |.915±.005|.031±.003|.571±.003|.067±.005
        motion-based (U), the thesis (V)          |.828±.010|.052±.004|.672±.003|-
        motion-based (U), the thesis (A)          |.799±.009|.056±.003|.648±.004|-
        prior-based (U), the thesis (V)           |-|-|.611±.003|.857±.024
        prior-based (U), the thesis (A)           |-|-|.641±.002|.949±.022
    """, STYLE_COLUMNS),
)  # fmt: skip
"""The thesis's variants and the methods it compares with."""

SEQUENCE_COLUMNS = ("transition_fid", "fid", "accuracy_top1", "diversity", "multimodality")
MULTIACT: Sequence[Published] = (
    *_rows("BABEL, one step", "MultiAct, table 2", """
        Real motions (test)  | - | .095 ± .0034 | .68 ± .0039 | 6.75 ± .045 | 3.73 ± .031
        MultiAct             | - | .97 ± .015   | .64 ± .009  | 6.74 ± .020 | 3.72 ± .019
        ACTOR                | - | 1.53 ± .032  | .50 ± .0078 | 6.52 ± .64  | 4.42 ± .043
    """, SEQUENCE_COLUMNS),
    *_rows("BABEL, one transition", "MultiAct, table 3", """
        MultiAct, after test motions  | .67 ± .027  | - | - | - | -
        MultiAct, after ACTOR         | 2.03 ± .73  | - | - | - | -
        ACTOR + SSMCT, aligned        | 5.85 ± .059 | - | - | - | -
        ACTOR + SSMCT                 | 7.20 ± .068 | - | - | - | -
        ACTOR + interpolation         | 13.36 ± .29 | - | - | - | -
    """, SEQUENCE_COLUMNS),
)  # fmt: skip
"""FID to the test set."""

PAPERS: dict[str, Papers] = {
    "action2motion": Papers("Action2Motion's protocol", COLUMNS, ACTION2MOTION, "“w/ Lie” is the variant `lie`."),
    "text2motion": Papers("Text2Motion's protocol", TEXT_COLUMNS, TEXT2MOTION, "“Real length”: made as long as the "
                          "real motion, which is how engines are asked here."),
    "multiact": Papers("MultiAct's protocol", SEQUENCE_COLUMNS, MULTIACT, "Of twenty steps (figure 6) the paper prints "
                       "no numbers."),
    "stylization": Papers("Generative stylization's protocol", STYLE_COLUMNS, STYLIZATION, "(S) supervised, (U) "
                          "unsupervised; (V), (A): over the codes of the VAE, of the AE; Div is under multimodality."),
}  # fmt: skip
"""By the name a protocol has in the basis of an evaluation."""
