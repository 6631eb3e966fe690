"""What the report's page shows, as values: built from a run alone, without writing anything. templates/page.html draws it."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from frictionbench.reports import choice, robustness, tables
from frictionbench.reports.accuracy import CHARGES, by_charge, partial_rankings
from frictionbench.reports.animation import Animation
from frictionbench.reports.charts import CHARTS
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.sheets import BANDS
from frictionbench.reports.drawing.tiles import Drawing
from frictionbench.reports.hard import HardShares, hard_shares
from frictionbench.reports.headline import MUCH_FORM, headline
from frictionbench.reports.recorded import Recorded, recorded_problems
from frictionbench.reports.reliability import sentences
from frictionbench.reports.run import Run
from frictionbench.reports.settings import Setting, settings, workers_on_all_cores
from frictionbench.reports.sheets import Sheet, sheets
from frictionbench.results.cells import scene_title
from frictionbench.results.shrunk import FOLDER
from frictionbench.results.verdicts import Verdict

MOST_CLAIMS = 200  # wrong claims listed on the page; more make it slow to load
MOST_SIMULATIONS = 300  # simulations of a scene listed on the page, for the same reason
FEW = 8  # curves that are distinguishable in one figure

CURVES = ["times", "energies", "penetrations", "load", "clock"]  # columns that no table shows

Records = list[dict[str, Any]]
Ranking = list[tuple[str, Records]]  # labels, each with its row of the summary at each target


@dataclass(frozen=True)
class Head:
    """The summary above all sections."""

    setup: str
    finished: bool
    problems: int
    ranked: int
    wrong_simulations: int
    classes: int
    disturbed: int
    without_core: int
    oversubscribed: int
    gaps: int
    overhead: float | None
    headline: list[str]
    reliability: list[tuple[str, str]]
    choices: list[tuple[str, dict[float, choice.Choice]]]


@dataclass(frozen=True)
class Marks:
    """The legend's families of solvers, and the solvers that a figure shows faded or without a band until they are chosen."""

    families: dict[str, str]
    faded: list[str]
    unbanded: list[str]


@dataclass(frozen=True)
class Solved:
    """Problems solved by target and class, verdicts, and their reasons."""

    matrices: dict[float, list[tuple[str, dict[str, Any]]]]
    ranked: list[str]
    trivial: Records
    verdicts: pd.DataFrame
    reasons: pd.DataFrame


@dataclass(frozen=True)
class Maps:
    """Failure maps as tables. failed: all cells that failed where a solution is known; smallest: one per map and solver."""

    robustness: pd.DataFrame
    changes: dict[str, list[str]]
    failed: pd.DataFrame
    smallest: Records
    costs: pd.DataFrame


@dataclass(frozen=True)
class Times:
    """Time to equal accuracy."""

    ranking: Ranking
    parts: pd.DataFrame
    charged: dict[float, pd.DataFrame]
    charges: Sequence[int]
    clocks: pd.DataFrame


@dataclass(frozen=True)
class SceneClass:
    """A class of problems. facts: its row of tables.problem_classes; example: its smallest scene for the command line."""

    facts: dict[str, Any]
    ranking: Ranking
    by_tolerance: Records
    simulations: Records
    animations: list[Animation]
    example: str


@dataclass(frozen=True)
class Page:
    """All that the page shows. The templates know each field by its name."""

    run: Run
    head: Head
    marks: Marks
    charts: dict[str, list[tuple[Chart, Sequence[Panel] | Sequence[Drawing]]]]
    solved: Solved
    hard: HardShares | None
    maps: Maps
    times: Times
    recorded: list[Recorded]
    classes: list[SceneClass]
    simulated_only: Records
    animations: list[Animation]
    sheets: list[Sheet]
    claims: pd.DataFrame
    claims_count: int
    settings: list[tuple[str, list[Setting]]]
    much_form: float = MUCH_FORM


def view(run: Run, animations: Sequence[Animation] = ()) -> Page:
    """The page of a run. animations: those at hand, shown with their scenes."""
    claims = tables.wrong_claims(run)
    scenes = set(run.rows["scene"])
    simulated = _simulated(run)
    return Page(
        run=run,
        head=_head(run),
        marks=Marks(_families(run), _but_the_best(run, FEW, FEW + 2), _but_the_best(run, BANDS, BANDS)),
        charts=_charts(run),
        solved=_solved(run),
        hard=hard_shares(run),
        maps=_maps(run),
        times=_times(run),
        recorded=recorded_problems(run),
        classes=_classes(run, simulated, animations),
        simulated_only=[row for scene, rows in simulated.items() if scene not in scenes for row in rows],
        animations=[one for one in animations if one.scene not in scenes],
        sheets=sheets(run),
        claims=claims.head(MOST_CLAIMS),
        claims_count=len(claims),
        settings=settings(run.manifest),
    )


def _head(run: Run) -> Head:
    disturbed = run.rows["disturbed"].eq(True)
    return Head(
        setup=_setup(run.manifest),
        finished="finished" in run.manifest,
        problems=run.rows.loc[run.rows["problem"] != "", "problem_id"].nunique(),
        ranked=run.ranked["problem_id"].nunique(),
        wrong_simulations=int((run.simulations["verdict"] == Verdict.WRONG).sum()),
        classes=run.rows["problem_class"].nunique(),
        disturbed=int(disturbed.sum()),
        without_core=int((disturbed & run.rows["core"].isna()).sum()),
        oversubscribed=workers_on_all_cores(run.manifest),
        gaps=tables.gaps(run),
        overhead=tables.overhead(run),
        headline=headline(run),
        reliability=sentences(run),
        choices=choice.choices(run),
    )


def _setup(manifest: dict[str, Any]) -> str:
    """The suite, and the facts about machine and versions that matter most, as far as the manifest has them."""
    parts = [f"suite {manifest['settings'].get('suite', 'unnamed')}"]
    for part, names in (
        ("machine", ("host", "processor", "cores", "system")),
        ("versions", ("frictionbench", "numpy", "numba")),
    ):
        values = manifest.get(part)
        if isinstance(values, dict):
            parts += [f"{name} {values[name]}"[:80] for name in names if name in values]
    return " · ".join(parts)


def _families(run: Run) -> dict[str, str]:
    """The tags of the labels of each family that has several."""
    rows = pd.concat([run.rows[["family", "label"]], run.simulations[["family", "label"]]]).drop_duplicates()
    rows = rows[rows["label"].isin(run.looks)].fillna("")
    return {
        str(family): " ".join(run.looks[label].tag for label in own["label"])
        for family, own in rows.groupby("family")
        if family and len(own) > 1
    }


def _but_the_best(run: Run, few: int, limit: int) -> list[str]:
    """The tags of all labels except the best few; none where there are no more than `limit`."""
    best = list(tables.best_first(run.summaries[min(run.summaries)]).index)[:few]
    return [look.tag for label, look in run.looks.items() if label not in best] if len(run.looks) > limit else []


def _charts(run: Run) -> dict[str, list[tuple[Chart, Sequence[Panel] | Sequence[Drawing]]]]:
    """By section of the page, the charts that have a panel to show."""
    found: dict[str, list[tuple[Chart, Sequence[Panel] | Sequence[Drawing]]]] = {}
    for chart in CHARTS:
        if panels := chart.panels(run)[chart.on_page]:
            found.setdefault(chart.section, []).append((chart, panels))
    return found


def _solved(run: Run) -> Solved:
    classes = tables.problem_classes(run)
    return Solved(
        matrices={target: tables.matrix(table) for target, table in run.summaries.items()},
        ranked=list(run.ranked["problem_class"].unique()),
        trivial=classes[(classes["problems"] > 0) & (classes["trivial"] == classes["problems"])].to_dict("records"),
        verdicts=tables.solvability(run),
        reasons=tables.reasons(run),
    )


def _maps(run: Run) -> Maps:
    cells = robustness.map_cells(run)
    failed = robustness.failures(cells)
    smallest = robustness.smallest(failed, run.shrunk).to_dict("records")
    for row in smallest:
        file = str(run.folder / FOLDER / row["file"])
        row["solve"] = shlex.join(["frictionbench", "solve", file, "--solver", row["variant"]]) if row["file"] else ""
    changes = {one.spec.name: robustness.changes(one) for one in cells if one.spec.constant}
    return Maps(robustness.robustness(cells), changes, failed, smallest, robustness.costs(run))


def _times(run: Run) -> Times:
    return Times(
        ranking=tables.ranking(run.summaries),
        parts=partial_rankings(run.times[run.outer_targets[-1]]),
        charged={target: by_charge(times) for target, times in run.times.items() if len(times)},
        charges=CHARGES,
        clocks=tables.clocks(run),
    )


def _simulated(run: Run) -> dict[str, Records]:
    """The simulations listed for each scene."""
    return {
        str(scene): own.drop(columns=CURVES).head(MOST_SIMULATIONS).to_dict("records")
        for scene, own in run.simulations.groupby("scene", sort=False)
    }


def _classes(run: Run, simulated: dict[str, Records], animations: Sequence[Animation]) -> list[SceneClass]:
    by_tolerance = {name: table.to_dict("records") for name, table in tables.by_class(run).groupby("problem_class")}
    scene_of = dict(zip(run.rows["problem_class"], run.rows["scene"], strict=True))
    ranked, examples = set(run.ranked["problem_class"]), _examples(run)
    return [
        SceneClass(
            facts=facts,
            ranking=tables.ranking(run.summaries, name) if name in ranked else [],
            by_tolerance=by_tolerance.get(name, []),
            simulations=simulated.get(scene_of[name], []),
            animations=[one for one in animations if one.scene == scene_of[name]],
            example=examples.get(name, ""),
        )
        for facts in tables.problem_classes(run).to_dict("records")
        for name in [facts["problem_class"]]
    ]


def _examples(run: Run) -> dict[str, str]:
    """The smallest scene of each class in the notation of the command line; none for a class of recorded problems."""
    smallest = run.rows.sort_values("contacts", kind="stable").drop_duplicates("problem_class")
    whole = smallest[(smallest["problem"] != "") & ~smallest["parameters"].str.contains('"file"', regex=False)]
    named = whole["scene"].str.fullmatch(r"[\w.-]+") & ~whole["parameters"].str.contains("'", regex=False)
    return {row.problem_class: scene_title(row.scene, row.parameters) for row in whole[named].itertuples()}
