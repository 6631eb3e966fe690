"""A row of the results: the columns known before a cell runs, so that a killed cell has a row as well, and those computed from
timed answers: verdict, residuals, labels of the answer, and times.
"""

import json

import numpy as np

from frictionbench.harness import machine
from frictionbench.harness.cells.timing import SLOW_FIRST, Timing
from frictionbench.harness.plans.plan import Cell, Plugin, Source, plugin_of
from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.analysis.mode import mode
from frictionbench.problems.analysis.outcomes import refined, velocity_distance
from frictionbench.problems.analysis.stability import backward_error
from frictionbench.problems.check import Array
from frictionbench.problems.verdicts import RANK, Verdict
from frictionbench.problems.verify import Finding, verify
from frictionbench.results.conventions import ANOTHER_OUTCOME, COLD
from frictionbench.results.schema import PROBLEM_FACTS
from frictionbench.results.store import Row
from frictionbench.solvers import Answer, SolverInfo, Status, find

MOST_IN_MODE = 24  # contacts up to which a row states the mode, one letter per contact in a column that is read by eye
REFINED_FROM = 1e-4  # residual below which an answer is refined to determine its outcome: the coarsest tolerance of the suites
NOTICEABLE = 1e-3  # seconds: a first call longer than this and than SLOW_FIRST times the repeats gets a remark


def known_row(cell: Cell, limit: float, plugins: tuple[Plugin, ...], record: Row | None = None) -> Row:
    """Return the columns of a cell and of its solver. record: of a solve cell's problem, whose facts are columns as well."""
    fields = {name: value for name, value in vars(cell).items() if name != "origin" and value is not None}
    columns = {"problems" if name == "count" else name: value for name, value in fields.items()}
    if record is None:
        columns["parameters"] = json.dumps(columns["parameters"], sort_keys=True)
    facts = {} if record is None else {name: record[name] for name in PROBLEM_FACTS}
    plugin = plugin_of(cell.variant, plugins)
    described = plugin.solvers[cell.variant] if plugin else solver_facts(cell.variant)
    return columns | facts | {"key": cell.key, "time_limit": limit} | described


def no_problem(source: Source, reason: str) -> Row:
    """Return the record of a source that yields no problem, with the reason, for the rows of its planned cells."""
    return blank_facts(source) | {"starts": {COLD: ""}, "reason": reason}


def blank_facts(source: Source, problem: str = "", step: int | None = None, phase: str = "", reference: str = "") -> Row:
    """Return PROBLEM_FACTS with only the origin of the problem filled in."""
    parameters = json.dumps(source.parameters, sort_keys=True)
    known = {"problem": problem, "scene": source.scene, "parameters": parameters, "step": step, "phase": phase}
    return dict.fromkeys(PROBLEM_FACTS) | known | {"reference": reference}


def solver_facts(variant: str) -> Row:
    """Return the columns of a row that describe a solver, our own or one of a loaded plug-in."""
    info, _ = find(variant)
    return {
        "solver": info.name,
        "family": info.family,
        "model": info.model,
        "members": ", ".join(info.members),
        "version": info.version or machine.revision(),
    }


def verified(problem: FrictionProblem | LCP, answer: Answer, info: SolverInfo, tol: float) -> Finding:
    """Verify an answer as a solution of the solver's model."""
    return verify(problem, answer, info.model, tol, quiet=bool(info.needs))


def finding_columns(
    problem: FrictionProblem | LCP,
    timing: Timing,
    info: SolverInfo,
    tol: float,
    limit: float,
    reference: Array | None,
    *,
    disturbed: bool,
) -> Row:
    """Verify the timed answers and return the columns of the result; if answers differ, the worst is reported.

    reference: impulses (nc, d) whose velocities are compared with those of the answer.
    disturbed: whether another process ran on the core, which may be why the first call was slow.
    """
    answers = [*((problem, answer) for answer in timing.answers), *timing.new_answers]  # a cache may hold results of other code
    findings = [(verified(posed, answer, info, tol), answer) for posed, answer in answers]
    finding, answer = max(findings, key=lambda pair: (RANK[pair[0].verdict], pair[0].residual))
    row: Row = {
        "status": answer.status.name,
        "claimed": answer.status is Status.SOLVED,
        "verdict": finding.verdict,
        "reason": finding.reason,
        "residual": finding.residual,
        "model_residual": finding.model_residual,
        "work": json.dumps(answer.work, sort_keys=True),
        **({} if isinstance(problem, LCP) else _contact_columns(problem, finding, answer, reference)),
    }
    remarks = [finding.reason]
    if len(timing.answers) > 1:
        remarks.append(f"the repeats disagree ({len(timing.answers)} different answers); the worst is reported")
    if not timing.solve:
        remarks.append("every call compiled or loaded something; no times are reported")
        return row | {"reason": "; ".join(filter(None, remarks))}
    row |= _times(timing)
    median = row["form_time"] + row["setup_time"] + row["solve_time"]
    row["first_time"] = timing.first
    if timing.reused:
        remarks.append(
            f"it reuses earlier results: a problem that differs in the last bits takes {timing.reused:.0f} times as long as "
            "the repeats; the times are those of such problems"
        )
    elif timing.first and timing.first > max(SLOW_FIRST * median, NOTICEABLE) and not disturbed:
        remarks.append(
            f"the first call took {timing.first / median:.0f} times as long as the repeats; it may reuse earlier results"
        )
    row["reason"] = "; ".join(filter(None, remarks))
    if median > limit:
        row |= {"verdict": Verdict.TIMEOUT, "reason": "its median time exceeds the limit"}
    return row


def _contact_columns(problem: FrictionProblem, finding: Finding, answer: Answer, reference: Array | None) -> Row:
    """Return the columns of an answer to a friction problem beyond its residuals."""
    free = problem.free_velocity
    energy, impulse = float(free @ (problem.mass @ free)) / 2 or 1.0, answer.impulse
    readable = problem.dimension == 2 and problem.contacts <= MOST_IN_MODE and impulse.shape == (problem.contacts, 2)
    return {
        "residual_floor": finding.floor,
        "fclib_error": finding.fclib_error,
        "backward_error": backward_error(problem, impulse),
        "energy_defect": abs(finding.energy_defect) / energy,
        "mode": mode(problem, impulse) if readable and np.isfinite(impulse).all() else None,
        **_velocity_columns(problem, finding, answer, reference),
    }


def _velocity_columns(problem: FrictionProblem, finding: Finding, answer: Answer, reference: Array | None) -> Row:
    """Return the distances from the reference's velocities to the answer's, and to those of the solution near the answer."""
    if reference is None:
        return {}
    error = velocity_distance(problem, answer.impulse, reference)
    if error is None or not finding.residual <= REFINED_FROM:
        return {"velocity_error": error}
    finest = answer.impulse if error <= ANOTHER_OUTCOME else refined(problem, answer.impulse)
    return {
        "velocity_error": error,
        "outcome_distance": None if finest is None else velocity_distance(problem, finest, reference),
    }


def _times(timing: Timing) -> Row:
    row: Row = {}
    for step, times in (("form", timing.form), ("setup", timing.setup), ("solve", timing.solve)):
        row |= {f"{step}_time": float(np.median(times)), f"{step}_times": times} if times else {}
    row |= {"clock_time": float(np.median(timing.clock))} if timing.clock else {}
    return row | ({"call_time": float(np.median(timing.calls))} if timing.calls else {})
