"""The contract: a solver that keeps it has no violation; one that breaks a single rule fails the check of that rule."""

import ctypes
from collections.abc import Callable
from dataclasses import replace as changed
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from frictionbench.commands.cli import app
from frictionbench.harness.contract import examine
from frictionbench.harness.contract.check import CHECKS, Subject
from frictionbench.harness.contract.checks import inapplicable
from frictionbench.solvers import Answer, Status, find
from tests.helpers.plugin import write

GOOD = "interior_point"


class Spoiled:
    """A good solver, spoiled in one way: spoil(problem, answer, limit, start) gives another answer, or None."""

    def __init__(self, spoil: Callable[..., Answer | None]) -> None:
        self._good, self._spoil, self.calls = find(GOOD)[1], spoil, 0

    def prepare(self, problem):
        return problem

    def solve(self, problem, tol, limit, start=None):
        self.calls += 1
        answer = self._good.solve(self._good.prepare(problem.fresh()), tol, limit)
        return self._spoil(self, problem, answer, limit, start) or answer


def nothing(problem) -> Answer:
    return Answer(np.zeros((problem.contacts, problem.dimension)), Status.SOLVED)


def whole(problem) -> Answer:
    """The answer of a solver that does not stop at its limit."""
    return find(GOOD)[1].solve(find(GOOD)[1].prepare(problem), 1e-10, None)


def rob(self, problem, *_):
    problem.friction.setflags(write=True)
    problem.friction[:] = 0


def lie_where(condition):
    return lambda self, problem, *_: nothing(problem) if problem.contacts and condition(problem) else None


def tangents(problem):
    return problem.q.reshape(problem.contacts, problem.dimension)[:, 1:]


SPOILT = {
    "first_calls": lambda self, problem, *_: nothing(problem) if self.calls == 3 else None,
    "input_unchanged": rob,
    "ordinary_problems": lambda self, problem, answer, *_: Answer(np.vstack([answer.impulse, answer.impulse]), answer.status),
    "no_contacts": lambda self, problem, answer, *_: None if problem.contacts else Answer(np.zeros(0), Status.FAILED),
    "single_contact": lie_where(lambda problem: problem.contacts == 1),
    "friction_bias": lie_where(lambda problem: problem.friction_bias.any()),
    "joints": lie_where(lambda problem: len(problem.joint_bias)),
    "bias": lie_where(lambda problem: (problem.bias < 0).any()),
    "islands": lie_where(lambda problem: problem.velocity_scale > 1e5),
    "redundant_contacts": lie_where(lambda problem: problem.contacts > 8),
    "duplicated_contacts": lie_where(lambda problem: len(problem.friction) > 2 and problem.bias[0] == problem.bias[1]),
    "frictionless": lie_where(lambda problem: not problem.friction.any()),
    "correct_status": lie_where(lambda problem: problem.contacts == 8),
    "deterministic": lambda self, problem, answer, *_: changed(answer, impulse=answer.impulse * (1 + 1e-12 * self.calls)),
    "work_limit": lambda self, problem, answer, limit, _: changed(whole(problem), work={"a": 999}) if limit else None,
    "warm_start": lambda self, problem, answer, limit, start: None if start is None else Answer(start, Status.SOLVED),
    "contact_order": lie_where(lambda problem: problem.q[0] > problem.q[-problem.dimension] + 1e-9),
    "tangent_sign": lie_where(lambda problem: tangents(problem)[:, 0].sum() < -1e-9),
    "tangent_frame": lie_where(lambda problem: problem.dimension == 3 and problem.tangent[[0]].count_nonzero() > 3),
    "unit_scaling": lie_where(lambda problem: np.abs(problem.q).max() < 1e-2),
}


@pytest.mark.parametrize("name", CHECKS)
def test_a_check_tells_the_good_solver_from_the_spoilt_one(name) -> None:
    info, good = find(GOOD)
    less = changed(info, lacks=("friction_bias", "joints"), warm_start=False, dimension=(2,))
    apart = name in ("friction_bias", "joints", "warm_start", "tangent_frame")
    assert (inapplicable(name, info), bool(inapplicable(name, less))) == ("", apart)
    assert list(CHECKS[name].violations(Subject(info, good))) == []
    found = list(CHECKS[name].violations(Subject(info, Spoiled(SPOILT[name]))))
    assert len({*found}) == len(found) > 0


def test_writing_into_arrays_is_found() -> None:
    """As LAPACK does, which factorises in place what it is given by its address, and who iterates in the start."""
    spoilt = Spoiled(lambda _, problem, *__: ctypes.memset(problem.dense().W.ctypes.data, 0, 8) and None)
    assert list(CHECKS["input_unchanged"].violations(Subject(find(GOOD)[0], spoilt)))
    spoilt = Spoiled(lambda *given: None if given[-1] is None else given[-1].fill(1.0))
    assert list(CHECKS["warm_start"].violations(Subject(find(GOOD)[0], spoilt)))


def test_the_solvers_message_is_told() -> None:
    """As where an executable lacks a library: the reason of all its failures."""
    spoilt = Spoiled(lambda _, problem, *__: changed(nothing(problem), status=Status.FAILED, detail="exit code 3:\nno library"))
    for name in ("no_contacts", "single_contact"):
        found = [*CHECKS[name].violations(Subject(find(GOOD)[0], spoilt))]
        told = examine.format_findings([examine.CheckResult("guest", name, found)])
        assert told.count("; exit code 3: no library\n") == len(found) > 0


def test_a_fault_of_the_first_call_is_reported(tmp_path: Path) -> None:
    """Of the call in which a worker loads the solver, and which no check makes."""
    first = "answer = fb.solve(problem, 'lemke', tol=tol); calls.append(1)"
    lies = "return Answer(answer.impulse + (len(calls) == 1), Status.SOLVED, answer.work)"
    plugin = write(tmp_path / "one.py", first="import frictionbench as fb; calls = []", body=f"{first}; {lies}")
    result = CliRunner().invoke(app, ["check-solver", str(plugin), "--jobs", "1"])
    assert "Answer the first call of a process" in result.output.partition("failed  first calls\n")[2]
    assert "the first call in its process, on a problem of one contact, is wrong, and the second is not" in result.output
    assert "  not applicable  tangent frame: in the plane there is one tangent\n" in result.output
    plugin.write_text(plugin.read_text(encoding="utf-8").replace("warm_start=True", "needs=('absent',)"), encoding="utf-8")
    result = CliRunner().invoke(app, ["check-solver", str(plugin)])
    assert (result.exit_code, "solver: guest: absent not installed" in str(result.exception)) == (1, True)


FAULTS = {
    "os.abort()": "Raise no error",
    "while True: pass": "End each call",
    "raise SystemExit(3)": "SystemExit: 3",
    "problem.friction[:] = 0": "do not write into the problem, copy its arrays: ValueError",
    "return problem.q": "the solver returned an object of type ndarray, not an Answer",
    "return Answer(problem.q, Status.SOLVED)": "the impulse has shape (16,), not (8, 2)",
}
QUICK, *SLOW = FAULTS


@pytest.mark.parametrize("body", [QUICK, *(pytest.param(body, marks=pytest.mark.slow) for body in SLOW)])
def test_a_fault_of_every_call_is_told_once_and_ends_the_checks(body, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(examine, "LIMIT", 2.0)
    plugin = write(tmp_path / "one.py", first="import os", body=body)
    result = CliRunner().invoke(app, ["check-solver", str(plugin), "--jobs=1"])
    assert FAULTS[body] in result.output
    assert (result.exit_code, result.output.count("failed  "), result.output.count("not tested before")) == (1, 1, 1)
