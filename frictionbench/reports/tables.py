"""The report's tables: which solvers solve which problems, how reliably and how fast; the classes of problems of a run and what
makes them hard (results.hardness); and the problems that are not ranked.

An answer to another law, or with a polygonal cone, solves its own model if the residual of that model is within the tolerance.
Its error is its residual by Coulomb's law. A problem can have several labels of hardness, and counts under each.
"""

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import pandas as pd

from frictionbench.problems.verdicts import Verdict, measured
from frictionbench.reports.accuracy import OVERALL
from frictionbench.reports.drawing.text import power, residual
from frictionbench.reports.run import EXCLUSIONS, Run
from frictionbench.results.conventions import ENDINGS, count, endings
from frictionbench.results.hardness import hardness

CLOCK_MARGIN = 0.1  # relative difference of a library's clock from solve_time that the overhead of a call does not explain
LISTED = 20  # values of an option that are named
ALL, NONE = "all", "none of these"


def solvability(run: Run) -> pd.DataFrame:
    """Return a row per label: left_out (cells of problems that are not ranked, which the other columns do not count), cells,
    claimed, each of ENDINGS, and error, the median residual by Coulomb's law of answers to another law or a polygon."""
    groups, ended = run.ranked.groupby("label"), pd.Series(endings(run.ranked), index=run.ranked.index, dtype=object)
    table = pd.DataFrame({"left_out": run.rows.groupby("label", sort=False).size()})
    table = table.assign(cells=groups.size(), claimed=groups["claimed"].sum())
    table = table.join(pd.crosstab(run.ranked["label"], ended).reindex(columns=list(ENDINGS))).fillna(0).astype(int)
    table["left_out"] -= table["cells"]
    return table.assign(error=model_errors(run.ranked)).reset_index()


def model_errors(rows: pd.DataFrame) -> "pd.Series[float]":
    """Return by label the median residual, by Coulomb's law, of the answers to another law or with a polygonal cone."""
    return rows[rows["verdict"] == Verdict.RELAXED].groupby("label")["residual"].median()


def reasons(run: Run) -> pd.DataFrame:
    """Return a row per label, verdict and reason with the number of cells."""
    rows = run.rows[run.rows["reason"] != ""]
    rows = rows.assign(verdict=endings(rows))
    return rows.groupby(["label", "verdict", "reason"], sort=False).size().rename("cells").reset_index()


def problem_classes(run: Run) -> pd.DataFrame:
    """Return a row per class, grouped by scene and ordered by size: the scene, the numbers of problems and of those not ranked,
    the ranges of contacts and unknowns, and the largest condition number."""
    problems = run.rows.sort_values("size").drop_duplicates("problem_id").sort_index()
    problems = problems.assign(order=pd.factorize(problems["scene"])[0], left_out=problems[list(EXCLUSIONS)].any(axis=1))
    problems = problems.sort_values(["order", "size"], kind="stable")
    table = problems.groupby("problem_class", sort=False).agg(
        scene=("scene", "first"),
        problems=("problem", lambda names: int((names != "").sum())),
        left_out=("left_out", "sum"),
        dimension=("dimension", "max"),
        contacts_from=("contacts", "min"),
        contacts_to=("contacts", "max"),
        size_from=("size", "min"),
        size_to=("size", "max"),
        condition=("condition", "max"),
    )
    return table.reset_index()


def best_first(summary: pd.DataFrame, problem_class: str) -> pd.DataFrame:
    """Return the rows of a class in a summary by label, ordered by the share of the problems solved, then by the mean."""
    rows = summary[summary["problem_class"] == problem_class].set_index("label")
    return rows.assign(share=rows["share"].round(9)).sort_values(["share", "mean"], ascending=[False, True])


def matrix(summary: pd.DataFrame, problem_class: str, classes: Collection[str]) -> list[tuple[str, dict[str, Any]]]:
    """Return the labels of a class, the best first, each with its rows for this class and for the other classes."""
    rows = summary[summary["problem_class"].isin([problem_class, *classes])]
    cells = {label: group.set_index("problem_class").to_dict("index") for label, group in rows.groupby("label")}
    return [(label, cells[label]) for label in best_first(summary, problem_class).index]


def ranking(summaries: dict[float, pd.DataFrame], problem_class: str) -> list[tuple[str, list[dict[str, Any]]]]:
    """Return the labels of a class, the best at the tightest target first, each with its row at each target."""
    ranked = {target: best_first(table, problem_class) for target, table in summaries.items()}
    return [(label, [table.loc[label].to_dict() for table in ranked.values()]) for label in ranked[min(ranked)].index]


def clocks(run: Run) -> pd.DataFrame:
    """Return a row per label whose library measures its own time: medians of solve_time and clock_time (s) and of their ratio;
    differs: whether the ratio differs from one by more than CLOCK_MARGIN."""
    rows = run.ranked[run.ranked["clock_time"].notna() & run.ranked["solve_time"].notna()]
    rows = rows.assign(solve_time=rows["call_time"].fillna(rows["solve_time"]))  # the call, for a library in another process
    ratio = rows["solve_time"] / rows["clock_time"].clip(lower=1e-7)
    groups = rows.assign(ratio=ratio).groupby("label", sort=False)
    table = groups[["solve_time", "clock_time", "ratio"]].median()
    return table.assign(differs=(table["ratio"] - 1).abs() > CLOCK_MARGIN).reset_index()


def reliabilities(run: Run) -> pd.DataFrame:
    """Return a row per label, the most often exact first: label, model, and numbers of problems at the tightest tolerance.
    problems: those it ran on; exact: residual of the exact problem within the tolerance; own: residual of the exact problem or
    of its own model within the tolerance; the others count verdicts."""
    rows = run.tightest[measured(run.tightest)]
    ended = {
        "problems": rows["tol"].notna(),
        "exact": rows["own_solved"] & (rows["residual"] <= rows["tol"]),
        "own": rows["own_solved"],
        **{name: rows["verdict"] == name for name in ("near_miss", "unjudgeable", "wrong", "timeout", "crashed")},
    }
    groups = rows[["label", "model"]].assign(**ended).groupby("label", sort=False)
    table = groups.agg({"model": "first"} | dict.fromkeys(ended, "sum"))
    return table.sort_values(["exact", "own"], ascending=False, kind="stable").reset_index()


def sentences(run: Run) -> list[tuple[str, str]]:
    """Return statements, each with the solvers for which it holds, as text with counts; those without solvers are left out."""
    reliable = reliabilities(run)
    if reliable.empty:
        return []
    tol = power(float(run.ranked["tol"].min()))
    complete, inexact = reliable["own"] == reliable["problems"], reliable["exact"] < reliable["problems"]
    rows = run.tightest[measured(run.tightest)]
    exact = (rows["own_solved"] & (rows["residual"] <= rows["tol"])).groupby([rows["label"], rows["dimension"]]).all()
    always = exact[exact].reset_index().groupby("label")["dimension"].agg(list)
    only = {label: "" if len(dims) == len(run.overall) else f" ({OVERALL[dims[0]]})" for label, dims in always.items()}
    errors = {label: f" ({residual(error)})" for label, error in model_errors(run.tightest).items()}
    counted = {
        name: {
            label: f" ({found} of {of} problems to {tol})"
            for label, found, of in reliable[["label", name, "problems"]].itertuples(index=False)
        }
        for name in ("wrong", "crashed")
    }
    another = "for another law, the convex relaxation or soft contact, median error in brackets"
    polygon = "with a polygon for the cone in space, median error by Coulomb's law in brackets"
    claims: list[tuple[str, pd.Series, Mapping[str, str]]] = [
        (f"Solve every problem that they accept to {tol}", reliable["label"].isin(only), only),
        (f"Solve every problem that they accept to {tol} {polygon}", complete & inexact & (reliable["model"] == "lcp"), errors),
        ("Wrong claims, with a residual above ten times the tolerance", reliable["wrong"] > 0, counted["wrong"]),
        ("Crashed", reliable["crashed"] > 0, counted["crashed"]),
        (f"Solve every problem that they accept to {tol} {another}", complete & inexact & (reliable["model"] != "lcp"), errors),
    ]
    return [
        (what, "; ".join(label + figure.get(label, "") for label in reliable["label"][holds]))
        for what, holds, figure in claims
        if holds.any()
    ]


class HardShares(NamedTuple):
    """where: in the plane or in space. tol: the tightest tolerance. problems: the number of problems of each column.

    table: a row per label with the share of problems solved in each column, the largest share of all problems first; NaN if a
    solver ran on none of them.
    """

    where: str
    tol: float
    problems: dict[str, int]
    table: pd.DataFrame


def hard_shares(run: Run) -> list[HardShares]:
    """Return the share of problems that each solver solves at the tightest tolerance, by the labels of hardness that occur.

    There is a table for the plane and one for space, if some problem there has a label. A solver's shares refer to the problems
    that it ran on. A problem counts as solved if the residual of the exact problem is within the tolerance.
    """
    rows = run.tightest[measured(run.tightest)]
    shares = [_shares(where, rows[rows["dimension"] == dimension]) for dimension, where in OVERALL.items()]
    return [table for table in shares if table]


def _shares(where: str, rows: pd.DataFrame) -> HardShares | None:
    labels = hardness(rows)
    if not labels.any(axis=None):
        return None
    solved = rows["verdict"] == Verdict.SOLVED
    every = labels.assign(**{ALL: True, NONE: ~labels.any(axis=1)})[[ALL, *labels, NONE]]
    columns = {name: inside for name, inside in every.items() if inside.any()}
    shares = pd.DataFrame({name: solved[inside].groupby(rows["label"]).mean() for name, inside in columns.items()})
    problems = {name: rows.loc[inside, "problem_id"].nunique() for name, inside in columns.items()}
    ordered = shares.sort_values(ALL, ascending=False, kind="stable").rename_axis("label").reset_index()
    return HardShares(where, float(rows["tol"].min()), problems, ordered)


def setting(run: Run) -> str:
    """Return a sentence on the suite, the options that replace parts of it, its problems and the machine of a run."""
    settings, machine, options = run.manifest["settings"], run.manifest.get("machine", {}), replaced(run.manifest)
    facts = [f"Suite {settings.get('suite', 'unnamed')}", f"run with {options}" if options else "", revision(run.manifest)]
    facts += [count(run.ranked["problem_id"].nunique(), "ranked problem"), count(run.ranked["variant"].nunique(), "solver")]
    processor = f"{machine.get('processor')}, {count(machine.get('cores'), 'core')}"
    finished = str(run.manifest.get("finished", ""))[:10]  # the day
    facts += [f"time limit {settings.get('time_limit')} s", processor, f"finished {finished}" if finished else "not finished"]
    return "; ".join(filter(None, facts)) + "."


def revision(manifest: dict[str, Any]) -> str:
    """Return the release and the revision of the code of a run."""
    return f"frictionbench {manifest.get('release', '')} revision {manifest.get('versions', {}).get('frictionbench')}"


def replaced(manifest: dict[str, Any]) -> str:
    """Return the options by which a run replaced parts of its suite, with their values; empty if it is the whole suite."""
    given = {name: manifest.get("options", {}).get(name) for name in ("scene", "solver", "tol", "time_limit", "data")}
    lists = {name: value if isinstance(value, list) else [value] for name, value in given.items() if value is not None}
    texts = {name: ", ".join(map(str, each)) if len(each) <= LISTED else f"{len(each)} values" for name, each in lists.items()}
    return "; ".join(f"{name.replace('_', ' ')} {text}" for name, text in texts.items())


def asked(run: Run) -> str:
    """Return a sentence on the tolerances of a run, which need not have each target among them."""
    tolerances = sorted(run.manifest["settings"].get("tolerances", []), reverse=True)
    return f"Tolerances asked for: {', '.join(map(residual, tolerances))}; a time to a target is the least that reaches it."


def exclusions(run: Run) -> str:
    """Return a sentence on how many problems each exclusion removes from the rankings, where the first that holds counts, and
    how many of the others have several outcomes."""
    left = run.rows.sort_values("contacts", kind="stable").drop_duplicates("problem_id")
    parts = []
    for name, what in EXCLUSIONS.items():
        parts += [f"{left[name].sum()} {what}"] if left[name].any() else []
        left = left[~left[name]]
    text = f"Left out of all rankings: {', '.join(parts) or 'none'}"
    if left["several_outcomes"].any():
        several = count(int(left["several_outcomes"].sum()), "problem")
        text += f"; rankings of one outcome also leave out {several} of the {len(left)}, with answers of several velocities"
    return text + "."


def workers_on_all_cores(manifest: dict[str, Any]) -> int:
    """Return the number of workers if they left no core to the main process, else 0; also 0 if the manifest does not tell."""
    workers, cores = manifest.get("workers"), manifest.get("machine", {}).get("cores")
    return workers if isinstance(workers, int) and isinstance(cores, int) and workers >= cores else 0
