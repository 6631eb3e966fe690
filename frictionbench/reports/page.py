"""The report: one self-contained HTML file made from a results folder.

Names and reasons in a results folder may come from an untrusted source. Therefore the template escapes all text, the page loads
nothing, the only script allowed is templates/page.js, by its hash, and names in figures are not interpreted.
"""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from frictionbench.problems.verdicts import Verdict, measured
from frictionbench.reports import robustness, tables
from frictionbench.reports.accuracy import OVERALL
from frictionbench.reports.batches import has_batches, write_batches
from frictionbench.reports.charts import CHARTS
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.choice import GLOSS, LISTED, choices, disturbed, headline
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.tiles import Drawing
from frictionbench.reports.recorded import motions, recorded_problems
from frictionbench.reports.run import Run, read_run
from frictionbench.reports.templates import write_page
from frictionbench.results.conventions import RankBy, endings

MOST_CLAIMS = 200  # wrong claims listed on the page; more make it slow to load
MOST_SIMULATIONS = 300  # simulations of a scene listed on the page, for the same reason
DISTINGUISHABLE = 8  # curves that can be distinguished in one figure
CURVES = ["times", "energies", "penetrations"]  # columns that no table shows
MUCH_FORM = 0.2  # share of form in the time above which this suite's formulation may determine the rank
MOST_FAILURES = 12  # kinds of failure listed for one solver, the most frequent ones
LONGEST_DESCRIPTION = 6000  # characters: three times the longest in this package; a plug-in's may be of any length

Values = dict[str, Any]
Records = list[dict[str, Any]]
Panels = Sequence[Panel] | Sequence[Drawing]


def write_report(folder: Path, run: Run | None = None) -> Path:
    """Write DIR/report.html; return its path.

    run: the result of read_run(folder), if at hand.
    Errors: results.files.ResultsError if DIR is not a results folder or a file in it cannot be read.
    """
    if has_batches(folder):
        return write_batches(folder)
    return write_page(folder / "report.html", "page.html", **view(run or read_run(folder)))


def view(run: Run) -> Values:
    """Return what the page of a run shows, under the names that the templates use."""
    claims = run.rows[run.rows["verdict"] == Verdict.WRONG]  # of trivial problems as well
    claims = claims.sort_values("residual", ascending=False, kind="stable", na_position="first")
    scenes = set(run.rows["scene"])
    runs = [run, run.ranked_by(run.rank_by.other)]
    rankings = [_ranked(one) for one in runs]
    simulated: dict[str, Records] = {
        str(scene): simulations.drop(columns=CURVES).head(MOST_SIMULATIONS).to_dict("records")
        for scene, simulations in run.simulations.groupby("scene", sort=False)
    }
    return {
        "run": run,
        "head": _head(run, rankings),
        "faded": _faded(run),
        "hard": tables.hard_shares(run),
        "charts": _charts(runs),
        "rankings": rankings,
        "scenes": _class_names(run),
        "errors": {
            where: tables.model_errors(own).to_dict() for where, own in run.ranked.groupby(run.ranked["dimension"].map(OVERALL))
        },
        "clocks": tables.clocks(run),
        "solved": {"verdicts": tables.solvability(run), "reasons": tables.reasons(run)},
        "maps": _maps(run),
        "recorded": recorded_problems(run),
        "classes": tables.problem_classes(run).to_dict("records"),
        "simulated": simulated,
        "simulated_only": [row for scene, rows in simulated.items() if scene not in scenes for row in rows],
        "sheets": _sheets(run),
        "claims": claims.head(MOST_CLAIMS),
        "claims_count": len(claims),
        "settings": {part: json.dumps(value, indent=1) for part, value in run.manifest.items() if part != "solvers"},
        "much_form": MUCH_FORM,
        "first_screen": LISTED,
        "gloss": GLOSS,
        "maps_first": bool(run.manifest["settings"].get("maps")) and not run.manifest["settings"].get("sources"),
    }


def _head(run: Run, rankings: Records) -> Values:
    """Return the values of the summary above all sections."""
    kinds, target = {one["by"]: one["kinds"] for one in rankings}, run.outer_targets[-1]
    return {
        "setup": tables.setting(run),
        "finished": "finished" in run.manifest,
        "problems": run.rows.loc[run.rows["problem"] != "", "problem_id"].nunique(),
        "ranked": run.ranked["problem_id"].nunique(),
        "wrong_simulations": int((run.simulations["verdict"] == Verdict.WRONG).sum()),
        "classes": run.rows["problem_class"].nunique(),
        "disturbed": disturbed(run),
        "exclusions": tables.exclusions(run),
        "oversubscribed": tables.workers_on_all_cores(run.manifest),
        "other_law": int((run.rows["claimed"] & (run.rows["verdict"] == Verdict.RELAXED)).sum()),
        "headline": {by: headline({by: kinds_first, **kinds}, target) for by, kinds_first in kinds.items()},
        "reliability": tables.sentences(run),
    }


def _ranked(run: Run) -> Values:
    """Return all values that depend on the time by which the run ranks. matrices: by target and class of OVERALL; overall: the
    rankings of these classes; classes: those of all other classes of problems."""
    scenes = _class_names(run)
    return {
        "by": run.rank_by,
        "kinds": choices(run),
        "matrices": {
            target: {where: tables.matrix(table, where, scenes[where]) for where in run.overall}
            for target, table in run.summaries.items()
        },
        "overall": {where: tables.ranking(run.summaries, where) for where in run.overall},
        "classes": {name: tables.ranking(run.summaries, name) for names in scenes.values() for name in names},
        "sequences": motions(run),
    }


def _class_names(run: Run) -> dict[str, list[str]]:
    """Return the classes of problems of each dimension."""
    where = run.ranked["dimension"].map(OVERALL)
    return {name: list(run.ranked.loc[where == name, "problem_class"].unique()) for name in run.overall}


def _faded(run: Run) -> list[str]:
    """Return the tags of all labels except the DISTINGUISHABLE best; none if there are at most two more."""
    table = run.summaries[min(run.summaries)]
    best = {label for where in run.overall for label in tables.best_first(table, where).index[:DISTINGUISHABLE]}
    return [look.tag for label, look in run.looks.items() if label not in best] if len(run.looks) > DISTINGUISHABLE + 2 else []


def _charts(runs: Sequence[Run]) -> dict[str, list[tuple[Chart, Mapping[RankBy, Panels]]]]:
    """Return by section the charts that have panels. Charts that depend on the ranking have panels for each of the runs."""
    by_section: dict[str, list[tuple[Chart, Mapping[RankBy, Panels]]]] = {}
    for chart in CHARTS.values():
        drawn = {run.rank_by: chart.panels(run)[chart.on_page] for run in (runs if chart.ranked else runs[:1])}
        if any(drawn.values()):
            by_section.setdefault(chart.section, []).append((chart, drawn))
    return by_section


def _maps(run: Run) -> Values:
    """Return failure maps as tables. failed: number of failed cells with a known solution; smallest: one per map and solver."""
    cells = robustness.map_cells(run)
    failed = robustness.failures(cells)
    smallest = robustness.smallest(failed).to_dict("records")
    changes = {one.spec.name: robustness.changes(one) for one in cells if one.spec.constant}
    return {"robustness": robustness.robustness(cells), "changes": changes, "failed": len(failed), "smallest": smallest}


def _sheets(run: Run) -> Records:
    """Return a sheet for each label that has cells, in alphabetical order: label, variant and facts; description: the solver's,
    in paragraphs, from the manifest; results: its rows of the summary for the classes of OVERALL, each with its target;
    failures: its first MOST_FAILURES rows of _failures."""
    descriptions = run.manifest.get("solvers", {})
    parts = [table.assign(target=target) for target, table in run.summaries.items()]
    results = pd.concat([part[part["problem_class"].isin(run.overall)] for part in parts])
    failed = _failures(run)
    sheets = []
    for row in run.rows.drop_duplicates("label").sort_values("label").to_dict("records"):
        label, variant = row["label"], row["variant"]
        text = descriptions.get(variant, "")
        facts = {name: str(row[name] or "") for name in ("family", "model", "version", "members")}
        sheets.append({
            "label": label,
            "variant": variant,
            "facts": {name: text for name, text in facts.items() if text not in ("", "nan", "None")},
            "description": [_flowing(part) for part in str(text)[:LONGEST_DESCRIPTION].split("\n\n") if part.strip()],
            "results": results[results["label"] == label].to_dict("records"),
            "failures": failed[failed["label"] == label].head(MOST_FAILURES).to_dict("records"),
        })  # fmt: skip
    return sheets


def _flowing(paragraph: str) -> str:
    """Join the lines of a paragraph, except for formulas, whose lines are all indented, and items of lists."""
    if all(line.startswith(" ") for line in paragraph.splitlines()):
        return paragraph
    return re.sub(r"\n(?!\* |\d\. |[A-Z]\w*: )\s*", " ", paragraph)


def _failures(run: Run) -> pd.DataFrame:
    """Return a row per label, class and verdict other than solved and skipped, the most frequent first: the number of cells, of
    all that ran (of), and contacts, residual, reason and key of the cell with the fewest contacts."""
    ran = run.ranked[measured(run.ranked)]
    of = ran.groupby(["label", "problem_class"]).size().rename("of")
    ran = ran.assign(verdict=endings(ran))
    failed = ran[ran["verdict"] != Verdict.SOLVED].sort_values(["contacts", "tol"], kind="stable")
    columns = ["contacts", "residual", "reason", "key"]
    kinds = failed.groupby(["label", "problem_class", "verdict"], sort=False)
    table = kinds[columns].first().assign(cells=kinds.size()).reset_index().join(of, on=["label", "problem_class"])
    return table.sort_values("cells", ascending=False, kind="stable")
