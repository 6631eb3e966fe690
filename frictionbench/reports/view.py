"""What the report's page shows, as values: built from a run alone, without writing anything. templates/page.html draws it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from frictionbench.reports import leave_out, mix, robustness, tables
from frictionbench.reports.accuracy import CHARGES, OVERALL, by_charge, overall, partial_rankings, percentiles
from frictionbench.reports.animation import Animation
from frictionbench.reports.charts import CHARTS
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.choice import Kind, choices, differs, headline
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.sheets import BANDS
from frictionbench.reports.drawing.tiles import Drawing
from frictionbench.reports.filter import cells
from frictionbench.reports.hard import HardShares, hard_shares
from frictionbench.reports.noise import Noise, sentence, timing_noise
from frictionbench.reports.recorded import Recorded, recorded_problems
from frictionbench.reports.reliability import sentences
from frictionbench.reports.run import Run
from frictionbench.reports.sequences import Motion, motions
from frictionbench.reports.settings import Setting, settings, workers_on_all_cores
from frictionbench.reports.sheets import Sheet, sheets
from frictionbench.results.commands import solve
from frictionbench.results.conventions import RankBy, scene_title
from frictionbench.results.extras import SHRUNK
from frictionbench.results.verdicts import Verdict

MOST_CLAIMS = 200  # wrong claims listed on the page; more make it slow to load
MOST_SIMULATIONS = 300  # simulations of a scene listed on the page, for the same reason
FEW = 8  # curves that are distinguishable in one figure

CURVES = ["times", "energies", "penetrations", "load", "clock"]  # columns that no table shows

Records = list[dict[str, Any]]
Ranking = list[tuple[str, Records]]  # labels, each with its row of the summary at each target
Panels = Sequence[Panel] | Sequence[Drawing]
FIRST_SCREEN = 8  # solvers listed for each dimension above the fold
MUCH_FORM = 0.2  # share of form in the time, above which the formulation by this suite may decide the rank


@dataclass(frozen=True)
class Head:
    """The summary above all sections. differs: whether the two rankings differ; families: which scenes decide the ranking."""

    setup: str
    finished: bool
    problems: int
    ranked: int
    wrong_simulations: int
    classes: int
    noise: Noise | None
    noise_told: str
    oversubscribed: int
    gaps: int
    other_law: int
    overhead: float | None
    headline: list[str]
    differs: bool
    families: list[str]
    reliability: list[tuple[str, str]]
    idle_share: float


@dataclass(frozen=True)
class Marks:
    """The legend's families of solvers, and the solvers that a figure shows faded or without a band until they are chosen."""

    families: dict[str, str]
    faded: list[str]
    unbanded: list[str]


@dataclass(frozen=True)
class Solved:
    """Verdicts and their reasons, the mix of the problems that are ranked, and those that are not."""

    verdicts: pd.DataFrame
    reasons: pd.DataFrame
    mix: pd.DataFrame
    left_out: pd.DataFrame


@dataclass(frozen=True)
class Maps:
    """Failure maps as tables. failed: all cells that failed where a solution is known; smallest: one per map and solver."""

    robustness: pd.DataFrame
    changes: dict[str, list[str]]
    failed: pd.DataFrame
    smallest: Records
    costs: pd.DataFrame


@dataclass(frozen=True)
class Ranked:
    """All that depends on the time by which solvers are ranked. matrices, overall, percentiles, charged: by target, then by the
    classes of all problems of a dimension; classes: the ranking of each class of problems; left_out: by dimension."""

    by: RankBy
    kinds: list[Kind]
    matrices: dict[float, dict[str, list[tuple[str, dict[str, Any]]]]]
    overall: dict[str, Ranking]
    percentiles: dict[float, dict[str, pd.DataFrame]]
    charged: dict[float, dict[str, pd.DataFrame]]
    parts: pd.DataFrame
    classes: dict[str, Ranking]
    sequences: list[Motion]
    left_out: dict[str, list[leave_out.LeftOut]]


@dataclass(frozen=True)
class SceneClass:
    """A class of problems. facts: its row of tables.problem_classes; example: its smallest scene for the command line."""

    facts: dict[str, Any]
    by_tolerance: Records
    simulations: Records
    animations: list[Animation]
    example: str


@dataclass(frozen=True)
class Page:
    """All that the page shows. The templates know each field by its name. maps_first: the run is one of maps alone."""

    run: Run
    head: Head
    marks: Marks
    charts: dict[str, list[tuple[Chart, Mapping[RankBy, Panels]]]]
    rankings: list[Ranked]
    scenes: dict[str, list[str]]
    errors: dict[str, dict[str, float]]
    clocks: pd.DataFrame
    solved: Solved
    hard: list[HardShares]
    maps: Maps
    recorded: list[Recorded]
    classes: list[SceneClass]
    simulated_only: Records
    animations: list[Animation]
    sheets: list[Sheet]
    claims: pd.DataFrame
    claims_count: int
    settings: list[tuple[str, list[Setting]]]
    maps_first: bool = False
    cells: dict[str, Any] = field(default_factory=dict)
    much_form: float = MUCH_FORM
    charges: Sequence[int] = CHARGES
    first_screen: int = FIRST_SCREEN


def view(run: Run, animations: Sequence[Animation] = ()) -> Page:
    """The page of a run. animations: those at hand, shown with their scenes."""
    claims = tables.wrong_claims(run)
    scenes = set(run.rows["scene"])
    runs = [run, run.ranked_by(run.rank_by.other)]
    rankings = [_ranked(one) for one in runs]
    simulated = _simulated(run)
    return Page(
        run=run,
        head=_head(run, rankings),
        marks=Marks(_families(run), _but_the_best(run, FEW, FEW + 2), _but_the_best(run, BANDS, BANDS)),
        hard=hard_shares(run),
        charts=_charts(runs),
        rankings=rankings,
        scenes=_scenes(run),
        errors={
            where: tables.model_errors(own).to_dict() for where, own in run.ranked.groupby(run.ranked["dimension"].map(OVERALL))
        },
        clocks=tables.clocks(run),
        solved=Solved(tables.solvability(run), tables.reasons(run), mix.mix(run), mix.left_out(run)),
        maps=_maps(run),
        recorded=recorded_problems(run),
        classes=_classes(run, simulated, animations),
        simulated_only=[row for scene, rows in simulated.items() if scene not in scenes for row in rows],
        animations=[one for one in animations if one.scene not in scenes],
        sheets=sheets(run),
        claims=claims.head(MOST_CLAIMS),
        claims_count=len(claims),
        settings=settings(run.manifest),
        cells=cells(run),
        maps_first=bool(run.manifest["settings"].get("maps")) and not run.manifest["settings"].get("sources"),
    )


def _head(run: Run, rankings: list[Ranked]) -> Head:
    kinds, target = {one.by: one.kinds for one in rankings}, run.outer_targets[-1]
    disturbance = timing_noise(run, kinds)
    return Head(
        setup=_setup(run.manifest),
        finished="finished" in run.manifest,
        problems=run.rows.loc[run.rows["problem"] != "", "problem_id"].nunique(),
        ranked=run.ranked["problem_id"].nunique(),
        wrong_simulations=int((run.simulations["verdict"] == Verdict.WRONG).sum()),
        classes=run.rows["problem_class"].nunique(),
        noise=disturbance,
        noise_told=sentence(disturbance, len(run.rows)) if disturbance else "",
        oversubscribed=workers_on_all_cores(run.manifest),
        gaps=tables.gaps(run),
        other_law=int((run.rows["claimed"] & (run.rows["verdict"] == Verdict.RELAXED)).sum()),
        overhead=tables.overhead(run),
        headline=headline(kinds, run.overall, target),
        differs=differs(kinds, target),
        families=leave_out.sentences({one.by: one.left_out for one in rankings}),
        reliability=sentences(run),
        idle_share=mix.idle_share(run),
    )


def _ranked(run: Run) -> Ranked:
    """The part of the page that depends on the time by which the run ranks."""
    wholes = {target: overall(times) for target, times in run.times.items() if target in run.outer_targets}
    scenes = _scenes(run)
    return Ranked(
        by=run.rank_by,
        kinds=choices(run),
        matrices={
            target: {where: tables.matrix(table, where, scenes[where]) for where in run.overall}
            for target, table in run.summaries.items()
        },
        overall={where: tables.ranking(run.summaries, where) for where in run.overall},
        percentiles={
            target: {where: percentiles(times, run.budget) for where, times in parts.items()}
            for target, parts in wholes.items()
        },
        charged={target: {where: by_charge(times) for where, times in parts.items()} for target, parts in wholes.items()},
        parts=partial_rankings(run.times[run.outer_targets[-1]]),
        classes={name: tables.ranking(run.summaries, name) for names in scenes.values() for name in names},
        sequences=motions(run),
        left_out=leave_out.left_out(run),
    )


def _scenes(run: Run) -> dict[str, list[str]]:
    """The classes of problems of each dimension."""
    where = run.ranked["dimension"].map(OVERALL)
    return {name: list(run.ranked.loc[where == name, "problem_class"].unique()) for name in run.overall}


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
    table = run.summaries[min(run.summaries)]
    best = {label for where in run.overall for label in tables.best_first(table, where).index[:few]}
    return [look.tag for label, look in run.looks.items() if label not in best] if len(run.looks) > limit else []


def _charts(runs: Sequence[Run]) -> dict[str, list[tuple[Chart, Mapping[RankBy, Panels]]]]:
    """By section of the page, the charts that have a panel to show; those that depend on the ranking for each of the runs."""
    found: dict[str, list[tuple[Chart, Mapping[RankBy, Panels]]]] = {}
    for chart in CHARTS:
        drawn = {run.rank_by: chart.panels(run)[chart.on_page] for run in (runs if chart.ranked else runs[:1])}
        if any(drawn.values()):
            found.setdefault(chart.section, []).append((chart, drawn))
    return found


def _maps(run: Run) -> Maps:
    cells = robustness.map_cells(run)
    failed = robustness.failures(cells)
    smallest = robustness.smallest(failed, run.shrunk).to_dict("records")
    for row in smallest:
        file = str(run.folder / SHRUNK / row["file"])
        row["solve"] = solve(file, row["variant"], row["tol"], run.plugins) if row["file"] else ""
    changes = {one.spec.name: robustness.changes(one) for one in cells if one.spec.constant}
    return Maps(robustness.robustness(cells), changes, failed, smallest, robustness.costs(run))


def _simulated(run: Run) -> dict[str, Records]:
    """The simulations listed for each scene."""
    return {
        str(scene): own.drop(columns=CURVES).head(MOST_SIMULATIONS).to_dict("records")
        for scene, own in run.simulations.groupby("scene", sort=False)
    }


def _classes(run: Run, simulated: dict[str, Records], animations: Sequence[Animation]) -> list[SceneClass]:
    by_tolerance = {name: table.to_dict("records") for name, table in tables.by_class(run).groupby("problem_class")}
    scene_of = dict(zip(run.rows["problem_class"], run.rows["scene"], strict=True))
    examples = _examples(run)
    return [
        SceneClass(
            facts=facts,
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
