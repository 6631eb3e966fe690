"""The report: one self-contained HTML file made from a results folder, without running anything again. It links to the
animations of the scenes, which lie beside it.

Names and reasons in a results folder may come from strangers: the template escapes all text, the page loads nothing and runs no
script but templates/page.js, by its hash, and figures are drawn without interpreting names.
"""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup

from frictionbench.reports import choice, robustness, settings, tables
from frictionbench.reports.accuracy import ALL, CHARGES, by_charge, entered_in_part
from frictionbench.reports.animation import write_animations
from frictionbench.reports.charts import CHARTS
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel, inline_svg, swatch
from frictionbench.reports.drawing.svg import on_page
from frictionbench.reports.drawing.text import power, scene_title, seconds
from frictionbench.reports.drawing.tiles import Drawing
from frictionbench.reports.recorded import recorded_problems
from frictionbench.reports.reliability import sentences
from frictionbench.reports.run import Run, read_run
from frictionbench.reports.sheets import sheets
from frictionbench.reports.templates import as_json, environment, script
from frictionbench.results.files import write_text
from frictionbench.results.polygon import read_deviations
from frictionbench.results.shrunk import FOLDER, read_shrunk
from frictionbench.results.verdicts import Verdict

MOST_CLAIMS = 200  # wrong claims listed on the page
FEW = 8  # labels that a figure shows well at once
BANDS = 3  # bands that it does
MOST_SIMULATIONS = 300  # of a scene, listed
CURVES = ["times", "energies", "penetrations", "load", "clock"]
MUCH_FORM = 0.2  # of the time: beyond this the writing of the problem decides the rank with the method


def write_report(folder: Path, run: Run | None = None) -> Path:
    """Write DIR/report.html, the animations in DIR/motion/ and what maps lost in DIR/failures.txt; return the report's path.

    run: what read_run(folder) gave, where it is at hand.
    Errors: results.store.ResultsError where DIR is not a results folder or a table cannot be read.
    """
    page = environment().get_template("page.html").render(_contents(folder, run or read_run(folder)))
    path = folder / "report.html"
    write_text(path, page)
    return path


def _contents(folder: Path, run: Run) -> dict[str, Any]:
    claims = tables.wrong_claims(run)
    mapped = robustness.map_cells(run)
    animations = write_animations(folder)
    text, digest = script("page.js")
    classes, ranked = tables.problem_classes(run), list(run.contested["problem_class"].unique())
    simulated = {
        str(scene): own.drop(columns=CURVES).head(MOST_SIMULATIONS).to_dict("records")
        for scene, own in run.simulations.groupby("scene", sort=False)
    }
    examples = _examples(run)
    scene_of = dict(zip(run.rows["problem_class"], run.rows["scene"], strict=True))
    return {
        "folder": folder.resolve().name,
        "run": run,
        "setup": _setup(run.manifest),
        "disturbed": int(run.rows["disturbed"].eq(True).sum()),
        "homeless": int((run.rows["disturbed"].eq(True) & run.rows["core"].isna()).sum()),
        "crowded": settings.crowded(run.manifest),
        "finished": "finished" in run.manifest,
        "problems": run.rows.loc[run.rows["problem"] != "", "problem_id"].nunique(),
        "contested": run.contested["problem_id"].nunique(),
        "gaps": tables.gaps(run),
        "headline": headline(run),
        "choices": choice.choices(run),
        "ends": run.ends,
        "reliability": sentences(run),
        "swatches": {label: Markup(swatch(one)) for label, one in run.looks.items()},
        "matrices": {target: tables.matrix(table) for target, table in run.summaries.items()},
        "races": {name: tables.race(run.summaries, name) for name in [ALL, *ranked]},
        "parts": entered_in_part(run.times[run.ends[-1]]),
        "charged": {target: by_charge(times) for target, times in run.times.items() if len(times)},
        "charges": CHARGES,
        "solvability": tables.solvability(run),
        "overhead": tables.overhead(run),
        "outcomes": list(Verdict),
        "verdicts": {verdict: verdict.meaning for verdict in Verdict},
        "reasons": tables.reasons(run),
        "robustness": robustness.robustness(mapped),
        "map_failures": robustness.failures(mapped, read_shrunk(folder)),
        "unsteady": {cells.spec.name: robustness.changes(cells) for cells in mapped if cells.spec.constant},
        "costs": robustness.costs(run),
        "all_lost": robustness.write_failures(folder, mapped),
        "again": lambda row: shlex.join(
            ["frictionbench", "solve", str(folder / FOLDER / row["file"]), "--solver", row["variant"]]
        ),
        "charts": _charts(run),
        "svg": lambda one: Markup(inline_svg(one) if isinstance(one, Panel) else on_page(one)),
        "json": as_json,
        "families": _families(run),
        "rest": _rest(run, FEW, FEW + 2),
        "unbanded": _rest(run, BANDS, BANDS),
        "script": text,
        "script_hash": digest,
        "by_class": {name: table.to_dict("records") for name, table in tables.by_class(run).groupby("problem_class")},
        "sheets": sheets(run),
        "simulations_of": lambda name: simulated.get(scene_of[name], []),
        "lone": [row for scene, rows in simulated.items() if scene not in scene_of.values() for row in rows],
        "example_of": lambda name: examples.get(name, ""),
        "classes": classes,
        "ranked": ranked,
        "trivial": classes[(classes["problems"] > 0) & (classes["trivial"] == classes["problems"])].to_dict("records"),
        "animations": [page for page in animations if page["scene"] not in scene_of.values()],
        "animations_of": lambda name: [page for page in animations if page["scene"] == scene_of[name]],
        "claims": claims.head(MOST_CLAIMS),
        "claims_count": len(claims),
        "settings": settings.settings(run.manifest),
        "clocks": tables.clocks(run),
        "much_form": MUCH_FORM,
        "rerun": lambda key: f"frictionbench rerun {shlex.quote(str(folder))} {shlex.quote(key)}",
        "scene_title": scene_title,
        "recorded": recorded_problems(run),
        "deviations": read_deviations(folder),
    }


def headline(run: Run) -> list[str]:
    """Two sentences: who reaches the finest target most often, and who reaches the coarsest fastest."""
    found = {target: tables.leaders(table) for target, table in run.summaries.items()}
    finest, coarsest = min(found), max(found)
    if not (best := found[finest]):
        sentences = [f"No solver reaches a verified residual of {power(finest)} on any non-trivial problem."]
    else:
        first, equals = best.most_often, best.equals
        on = f"on {first['reached']} of {first['problems']} non-trivial problems"
        if equals > 1:
            tie = f"{equals} solvers reach a verified residual of {power(finest)} equally often, {on}; the fastest of them is"
            sentences = [f"{tie} {first['label']}, with a mean of {seconds(first['mean'])}{_written(first)}."]
        else:
            alone = f"{first['label']} reaches a verified residual of {power(finest)} most often: {on}"
            sentences = [f"{alone}, with a mean of {seconds(first['mean'])}{_written(first)}."]
    if best := found[coarsest]:
        sentences.append(
            f"For {power(coarsest)} {best.fastest['label']} is the fastest of those that reach it about as often as any: on "
            f"{best.fastest['reached']} of {best.fastest['problems']}, with a mean of {seconds(best.fastest['mean'])}"
            f"{_written(best.fastest)}."
        )
    return sentences


def _written(row: pd.Series) -> str:
    """How much of an label's time is form, marked where it is much."""
    much = ", more than a fifth" if row["written"] > MUCH_FORM else ""
    return f" (of it form, the writing of the problem: {100 * row['written']:.0f} %{much})"


def _setup(manifest: dict[str, Any]) -> str:
    """Suite, machine and versions that matter most, as far as the manifest tells."""
    parts = [f"suite {manifest['settings'].get('suite', 'unnamed')}"]
    for part, names in (
        ("machine", ("host", "processor", "cores", "system")),
        ("versions", ("frictionbench", "numpy", "numba")),
    ):
        values = manifest.get(part)
        if isinstance(values, dict):
            parts += [f"{name} {values[name]}"[:80] for name in names if name in values]
    return " · ".join(parts)


def _examples(run: Run) -> dict[str, str]:
    """Of each class of scenes the smallest, as the command line takes it; none of a class of recorded problems."""
    smallest = run.rows.sort_values("contacts", kind="stable").drop_duplicates("problem_class")
    whole = smallest[(smallest["problem"] != "") & ~smallest["parameters"].str.contains('"file"', regex=False)]
    named = whole["scene"].str.fullmatch(r"[\w.-]+") & ~whole["parameters"].str.contains("'", regex=False)
    return {row.problem_class: scene_title(row.scene, row.parameters) for row in whole[named].itertuples()}


def _families(run: Run) -> dict[str, str]:
    """The tags of each family's labels, for families of several."""
    rows = pd.concat([run.rows[["family", "label"]], run.simulations[["family", "label"]]]).drop_duplicates()
    rows = rows[rows["label"].isin(run.looks)].fillna("")
    return {
        str(family): " ".join(run.looks[label].tag for label in own["label"])
        for family, own in rows.groupby("family")
        if family and len(own) > 1
    }


def _rest(run: Run, few: int, bearable: int) -> list[str]:
    """The tags of those that stand back until somebody chooses: all but the best few, where there are more than bearable."""
    best = list(tables.best_first(run.summaries[min(run.summaries)]).index)[:few]
    return [look.tag for label, look in run.looks.items() if label not in best] if len(run.looks) > bearable else []


def _charts(run: Run) -> dict[str, list[tuple[Chart, Sequence[Panel] | Sequence[Drawing]]]]:
    """Of each section of the page the charts that have something to show, with their panels."""
    found: dict[str, list[tuple[Chart, Sequence[Panel] | Sequence[Drawing]]]] = {}
    for chart in CHARTS:
        if panels := chart.panels(run)[chart.on_page]:
            found.setdefault(chart.section, []).append((chart, panels))
    return found
