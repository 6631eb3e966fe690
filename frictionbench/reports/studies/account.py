"""What a study tells: an answer in a line, the result in words with numbers from its tables, its limits, and its figures.

A file of this folder has one function, `account`, from the study's tables to an Account. The words depend on the numbers:
where another run could contradict a sentence, the sentence is chosen by the tables, or StudyTables.require refuses to tell it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import Look


@dataclass(frozen=True)
class Figure:
    """Panels side by side with one caption. looks: of the lines named in a common legend. columns: of panels."""

    name: str
    caption: str
    panels: Sequence[Panel]
    looks: Mapping[str, Look] = field(default_factory=dict)
    columns: int = 2


@dataclass(frozen=True)
class Account:
    """answer: a line. result, limits: paragraphs; limits says what the study does not show. table: rows, the heads first."""

    answer: str
    result: str
    limits: str
    figures: Sequence[Figure] = ()
    table: Sequence[Sequence[str]] = ()
