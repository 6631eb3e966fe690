"""How solvers get to their answers, on a few problems of a run, kept as DIR/courses.json."""

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

from frictionbench.results.files import ResultsError, write_text

NAME = "courses.json"


class Course(NamedTuple):
    """A solver on one problem, stopped after so many units of its own work (sweeps, iterations, pivots), and so on.

    parameters: the scene's, JSON. units: work allowed, rising. residuals: verified, of the answer at each. impulse: of the
    last answer, per contact (normal, tangential...), N s; empty where it was not kept. redundant: W lacks rank, so that
    impulses are not unique.
    """

    scene: str
    parameters: str
    step: int | None
    variant: str
    contacts: int
    redundant: bool
    units: list[int]
    residuals: list[float]
    impulse: list[list[float]]


def write_courses(folder: Path, found: list[Course]) -> None:
    write_text(folder / NAME, json.dumps([course._asdict() for course in found]))


def read_courses(folder: Path) -> list[Course]:
    """As written; none where nothing was. Errors: ResultsError where the file cannot be read."""
    path = folder / NAME
    if not path.exists():
        return []
    try:
        return [_course(row) for row in json.loads(path.read_text(encoding="utf-8"))]
    except (OSError, ValueError, TypeError, LookupError, RecursionError, OverflowError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None


def _course(row: Any) -> Course:
    course = Course(
        str(row["scene"]),
        str(row["parameters"]),
        None if row["step"] is None else int(row["step"]),
        str(row["variant"]),
        int(row["contacts"]),
        bool(row["redundant"]),
        [int(count) for count in row["units"]],
        [float(value) for value in row["residuals"]],
        [[float(part) for part in contact] for contact in row["impulse"]],
    )
    numbers = [*course.residuals, *(part for contact in course.impulse for part in contact)]
    if len(course.units) != len(course.residuals) or not all(map(math.isfinite, numbers)):
        raise ValueError(f"the course of {course.variant} on {course.scene} is not whole")
    return course
