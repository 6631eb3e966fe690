"""A comparison as files for other programs, written into one folder.

comparison.md      the text shown in the terminal
comparison.json    all results as data
junit.xml          a test suite per solver with a test case per cell, counter and time (JUnit)
"""

from dataclasses import fields
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import Verdict
from frictionbench.reports.comparison.markdown import format_verdicts, markdown, rerun_command
from frictionbench.reports.drawing.text import residual
from frictionbench.results.cells import read
from frictionbench.results.changes import GONE, KINDS, Change, Flip
from frictionbench.results.compare import Comparison
from frictionbench.results.conventions import number
from frictionbench.results.files import json_text, printable, replaced, write_text


def write_files(comparison: Comparison, folder: Path) -> None:
    """Write the files. Errors: OSError, ResultsError naming the file."""
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "comparison.md", markdown(comparison))
    write_text(folder / "comparison.json", json_text(data(comparison)) + "\n")
    cells = pd.DataFrame() if comparison.unusable else read(comparison.current).table
    with replaced(folder / "junit.xml") as partial:
        ElementTree.ElementTree(junit(comparison, cells)).write(partial, encoding="utf-8", xml_declaration=True)


def data(comparison: Comparison) -> dict[str, Any]:
    """Return the comparison as plain values."""
    plain = {field.name: getattr(comparison, field.name) for field in fields(comparison) if field.name != "changes"}
    found: dict[str, list[dict[str, Any]]] = {kind: [] for kind in KINDS}
    for change in comparison.changes:
        command = {"command": rerun_command(comparison, change)} if isinstance(change, Flip) else {}
        found[change.kind].append(vars(change) | {"worse": change.worse} | command)
    return {"exit_code": comparison.exit_code, "counts": comparison.counts, **plain, **found}


def junit(comparison: Comparison, cells: pd.DataFrame) -> ElementTree.Element:
    """Return the comparison as JUnit XML. Each text is made `printable`, since XML 1.0 excludes most control characters."""
    root = ElementTree.Element("testsuites", name="frictionbench compare")
    worse = {(change.variant, getattr(change, "key", change.name)): change for change in comparison.worse}
    suites: dict[str, ElementTree.Element] = {}

    def case(variant: str, name: str, identity: str, skipped: str | None = None) -> None:
        if variant not in suites:
            suites[variant] = ElementTree.SubElement(root, "testsuite", name=printable(variant))
        one = ElementTree.SubElement(suites[variant], "testcase", classname=printable(variant), name=printable(name))
        if change := worse.get((variant, identity)):
            ElementTree.SubElement(one, "failure", message=printable(message(change))).text = (
                printable(rerun_command(comparison, change)) if isinstance(change, Flip) else None
            )
        elif skipped is not None:
            ElementTree.SubElement(one, "skipped", message=printable(skipped))

    for key, cell in cells.iterrows():
        name = f"{cell['scene']} {cell['table']} {cell['step']} {cell['phase']} {cell['start']} to {number(cell['tol'])}"
        case(cell["variant"], name, str(key), cell["reason"] if cell["verdict"] == Verdict.SKIPPED else None)
    for change in comparison.changes:
        if not isinstance(change, Flip):
            case(change.variant, change.name, change.name)
        elif change.after == GONE:
            case(change.variant, change.name, change.key)
    if comparison.unusable:
        one = ElementTree.SubElement(ElementTree.SubElement(root, "testsuite", name="runs"), "testcase", name="comparable")
        ElementTree.SubElement(one, "error", message=printable(comparison.unusable))
    return root


def message(change: Change) -> str:
    """Return a change as one line."""
    if isinstance(change, Flip):
        residuals = " → ".join(residual(each, 1) for each in (change.residual_before, change.residual_after))
        return f"{format_verdicts(change)}, residual {residuals} {change.reason}".strip()
    before, after = ("none" if side is None else f"{side:.6g}" for side in (change.before, change.after))
    return f"{change.name}: {before} → {after}" + (f", ×{change.ratio:.2f}" if np.isfinite(change.ratio) else "")
