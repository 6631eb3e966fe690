"""A sheet per solver: its properties, its own description, its results, and its failures, the smallest problems first."""

import re
from typing import Any

import pandas as pd

from frictionbench.problems.verdicts import Verdict, measured
from frictionbench.reports.run import Run
from frictionbench.results.conventions import endings

MOST_FAILURES = 12  # kinds of failure listed for one solver, the most frequent ones
LONGEST = 6000  # characters of a description, three times the longest in this package; a plug-in's may be of any length


def sheets(run: Run) -> list[dict[str, Any]]:
    """The sheets of all labels that have cells, in alphabetical order: label, variant, facts, description: its own, in
    paragraphs, from the manifest; results: its rows of the summary over all problems of the plane and of space, each with its
    target; failures: rows of _failures, the first MOST_FAILURES."""
    descriptions = run.manifest.get("solvers", {})
    parts = [table.assign(target=target) for target, table in run.summaries.items()]
    results = pd.concat([part[part["problem_class"].isin(run.overall)] for part in parts])
    failed = _failures(run)
    found = []
    for row in run.rows.drop_duplicates("label").sort_values("label").to_dict("records"):
        label, variant = row["label"], row["variant"]
        text = descriptions.get(variant, "")
        facts = {name: str(row[name] or "") for name in ("family", "model", "version", "members")}
        found.append({
            "label": label,
            "variant": variant,
            "facts": {name: text for name, text in facts.items() if text not in ("", "nan", "None")},
            "description": [_flowing(part) for part in str(text)[:LONGEST].split("\n\n") if part.strip()],
            "results": results[results["label"] == label].to_dict("records"),
            "failures": failed[failed["label"] == label].head(MOST_FAILURES).to_dict("records"),
        })  # fmt: skip
    return found


def _flowing(paragraph: str) -> str:
    """The paragraph with its lines joined, except formulas, which are indented as a whole, and items of lists."""
    if all(line.startswith(" ") for line in paragraph.splitlines()):
        return paragraph
    return re.sub(r"\n(?!\* |\d\. |[A-Z]\w*: )\s*", " ", paragraph)


def _failures(run: Run) -> pd.DataFrame:
    """A row per label, class and verdict other than solved and skipped, the most frequent first: cells, of all that ran (of);
    and contacts, residual, reason and key of the one with the fewest contacts."""
    ran = run.ranked[measured(run.ranked)]
    of = ran.groupby(["label", "problem_class"]).size().rename("of")
    ran = ran.assign(verdict=endings(ran))
    failed = ran[ran["verdict"] != Verdict.SOLVED].sort_values(["contacts", "tol"], kind="stable")
    columns = ["contacts", "residual", "reason", "key"]
    kinds = failed.groupby(["label", "problem_class", "verdict"], sort=False)
    table = kinds[columns].first().assign(cells=kinds.size()).reset_index().join(of, on=["label", "problem_class"])
    table = table.sort_values("cells", ascending=False, kind="stable")
    return table[["label", "problem_class", "verdict", "cells", "of", *columns]]
