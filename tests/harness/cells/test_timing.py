"""Form, setup and solve are timed separately, without calls that compile or load code; the clock is simulated."""

import json
import sys
from collections import Counter
from dataclasses import replace
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from numba import njit

from frictionbench.harness.cells import simulation, timing, worker
from frictionbench.harness.cells.rows import finding_columns
from frictionbench.harness.deadline import Deadline
from frictionbench.harness.plans.plan import SimulationCell
from frictionbench.problems.catalogue import scene
from frictionbench.problems.simulate import simulate
from frictionbench.solvers import Answer, SolverInfo, Status, find, solve
from frictionbench.solvers.interface import with_all_steps
from tests.helpers.friction_problems import block

LOADING = 1000.0  # seconds


class Clock:
    """Seconds that pass when a test says so."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(timing, "perf_counter", clock)
    monkeypatch.setattr(timing, "waited", lambda: 0.0)  # seconds of this machine, which are none of the clock's
    yield clock
    for name in [name for name in sys.modules if name.startswith("loaded_late")]:
        del sys.modules[name]


class Late:
    """Takes 1 s to form, 2 to set up, 4 to solve, and LOADING more in the calls, so many, in which it loads something."""

    def __init__(self, clock, loads=0, how="compile", seconds=1.0):
        self.clock, self.left, self.how, self.seconds = clock, loads, how, seconds

    def form(self, problem):
        self.clock.now += self.seconds
        return problem

    def setup(self, formed):
        self.clock.now += 2 * self.seconds
        return formed

    def solve(self, problem, tol, limit, start=None):
        self.clock.now += 4 * self.seconds
        if self.left:
            self.left -= 1
            self.clock.now += LOADING
            if self.how == "compile":
                njit(lambda x: x + 1)(1.0)
            else:
                sys.modules[f"loaded_late_{self.left}"] = ModuleType("loaded_late")
        return Answer(np.zeros((problem.contacts, problem.dimension)), Status.STALLED)


def timed(method, **given):
    call = lambda ready: method.solve(ready, 1e-8, None)  # noqa: E731
    return timing.time_solver(method, block(), call, lambda: None, lambda *_: 0, **given)


def test_form_setup_and_solve_times(clock):
    found = timed(Late(clock))
    assert (found.form, found.setup, found.solve) == ([1.0], [2.0], [4.0])
    quick = timed(Late(clock, seconds=2.0**-10))
    assert len(quick.form) == len(quick.setup) == len(quick.solve) == int(timing.BUDGET / (7 * 2.0**-10))
    assert set(quick.form) == {2.0**-10}


class Remote(Late):
    """Its process takes half of the 4 s to solve; after it, the first form takes ten times as long."""

    cold = False

    def form(self, problem):
        self.clock.now, self.cold = self.clock.now + 9 * self.seconds * self.cold, False
        return super().form(problem)

    def solve(self, problem, tol, limit, start=None):
        self.cold = True
        return replace(super().solve(problem, tol, limit), clock=2 * self.seconds)


def test_a_library_in_another_process_is_timed_by_its_own_clock(clock):
    found = timed(Remote(clock, seconds=2.0**-10), remote=True)
    form, solve, call, own = (set(times) for times in (found.form, found.solve, found.calls, found.clock))
    assert (form, solve, call, own) == ({2.0**-10}, {2.0**-9}, {6 * 2.0**-10}, {2.0**-9})
    assert set(found.setup) == {0.0}


@pytest.mark.parametrize("seconds", [2.0**-10, 1.0])
@pytest.mark.parametrize("loads", [1, 3])
@pytest.mark.parametrize("how", ["compile", "import"])
def test_loading_calls_are_discarded(clock, how, loads, seconds):
    found = timed(Late(clock, loads, how, seconds))
    assert set(found.solve) == {4 * seconds}
    assert found.spent > loads * LOADING
    every = timed(Late(clock, 10**6, how, seconds))
    assert (every.form, every.setup, every.solve) == ([], [], [])


class Memoises(Late):
    """Takes 7 s for each problem it has not met, or 7 ms, and a thousandth of it afterwards."""

    def __init__(self, clock, seconds, loads=0, known=()):
        super().__init__(clock, loads, seconds=seconds)
        self.usual, self.known = seconds, set(known)

    def form(self, problem):
        self.seconds = self.usual / 1000 if problem.hash in self.known else self.usual
        self.known.add(problem.hash)
        return super().form(problem)


@pytest.mark.parametrize("seconds", [1.0, 2.0**-10])
@pytest.mark.parametrize("loads", [0, 1])
@pytest.mark.parametrize("known", [False, True])
def test_reused_results_are_not_timed(clock, seconds, loads, known):
    """Also where the first call is not told from loading, or the problem was met in an earlier cell."""
    timed(Memoises(clock, seconds))  # loads what a problem's hash needs
    method = Memoises(clock, seconds, loads, [block().hash] if known else [])
    found = timed(method)
    if seconds == 1.0 and not loads and not known:
        assert (found.solve, found.reused) == ([4.0], None)  # its first call is its sample
    else:
        assert found.solve == pytest.approx([4 * seconds] * 2)
        assert (found.reused, len(found.new_answers)) == (pytest.approx(1000), 2)


class ReadsBack(Memoises):
    """The second call on a problem, the first to read a file, takes a third of the first."""

    second = frozenset[str]()

    def form(self, problem):
        formed = super().form(problem)
        if self.seconds < self.usual and problem.hash not in self.second:
            self.second |= {problem.hash}
            self.seconds = self.usual / 3
        return formed


def test_results_read_from_a_file_are_not_timed(clock):
    assert timed(ReadsBack(clock, 2.0**-10)).reused == pytest.approx(1000)


def test_answers_to_new_problems_are_verified() -> None:
    """The others are kept on disk, and of a version that was right. Finding them there need not be faster than the solver."""
    good, bad, info = solve(block(), "lemke"), Answer(np.ones((1, 2)), Status.SOLVED), find("lemke")[0]
    steps, known = SimpleNamespace(form=lambda given: given, setup=lambda given: given), block().hash
    rank = lambda _, answer: answer.impulse.tolist() == [[1.0, 1.0]]  # noqa: E731
    for unmet, verdict in (good, "solved"), (bad, "wrong"):
        slow = timing.Timing(False, [1.0], [1.0], [1.0], answers=[good], reused=9.0, new_answers=[(block(), unmet)])
        call = lambda given, new=unmet: good if given.hash == known else new  # noqa: E731
        for found in slow, timing.time_solver(steps, block(), call, lambda: None, rank):
            row = finding_columns(block(), found, info, 1e-8, 10.0, None, disturbed=False)
            assert (row["verdict"], "it reuses earlier results" in row["reason"]) == (verdict, found is slow)
    with pytest.raises(ZeroDivisionError):
        timing.time_solver(steps, block(), lambda given: good if given.hash == known else 1 / 0, lambda: None, rank)


def test_long_call_on_a_problem_met_before_is_questioned(clock):
    method = Memoises(clock, 1000.0, known=[block().hash])
    assert timed(method, met_before=True).solve == [4000.0] * 2


def test_a_wait_for_a_core_is_no_reuse(clock, monkeypatch):
    """The same times as of a solver that reuses results, but the core ran another process meanwhile."""
    timed(Memoises(clock, 1.0))
    method = Memoises(clock, 2.0**-10)
    usual, wait = method.usual / 1000, Clock()
    monkeypatch.setattr(timing, "waited", wait)
    form = method.form

    def preempted(problem):
        formed = form(problem)
        wait.now += 7 * (method.seconds - usual)  # all that the call on a new problem takes longer
        return formed

    method.form = preempted
    assert timed(method).reused is None


def test_simulation_discards_loading_calls(clock):
    info = SolverInfo("late", "test", "coulomb", (2,), False, (), (), False, (), (), "double", Late)
    cell = SimulationCell("stopping_block", {}, "late", 1e-8, steps=3)
    stage = scene("stopping_block")
    found = simulation.run_closed_loop(cell, stage, info, Late(clock, loads=2))
    assert found["solver_time"] == 7.0 * found["problems"]
    assert simulation.run_closed_loop(cell, stage, info, Late(clock, loads=10**6))["solver_time"] is None
    keeps = Memoises(clock, 1.0)
    taken = [simulation.run_closed_loop(cell, stage, info, keeps)["solver_time"] for _ in range(2)]
    assert taken == [7.0 * found["problems"], None]
    kept, known, bad = Late(clock), {}, Answer(np.ones((1, 2)), Status.SOLVED)
    for made, verdict in (solve, "solved"), (lambda *_: bad, "wrong"):  # by the first version, and by a later one
        kept.solve = lambda given, *_, new=made: known.setdefault(given.hash, new(given, "lemke"))
        row = simulation.run_closed_loop(cell, stage, info, kept)
        assert (row["verdict"], row["solver_time"] is not None, row["unsolved"]) == (verdict, verdict == "solved", 0)


def test_a_simulation_sums_the_counters_of_its_steps():
    stage, work = scene("stopping_block"), Counter()

    def answered(problem):
        work.update((answer := solve(problem, "lemke")).work)
        return answer.impulse

    assert list(simulate(stage, answered, steps=3))
    assert work["pivots"] > 3
    row = simulation.run_closed_loop(SimulationCell("stopping_block", {}, "lemke", 1e-8, steps=3), stage, *find("lemke"))
    assert json.loads(row["work"]) == work


@pytest.mark.parametrize("name", ["lemke", "path_search", "interior_point", "nsgs", "admm", "hybrid"])
def test_prepare(name):
    _, method = find(name)
    problem = block()
    apart = method.solve(method.setup(method.form(problem.fresh())), 1e-8, None)
    assert np.array_equal(apart.impulse, method.solve(method.prepare(problem.fresh()), 1e-8, None).impulse)
    assert np.array_equal(apart.impulse, solve(problem, name).impulse)


def test_default_steps():
    form = with_all_steps(type("FormAlone", (), {"form": lambda self, problem: ("formed", problem)}))()
    assert (form.form(1), form.setup(1), form.prepare(1)) == (("formed", 1), 1, ("formed", 1))
    with pytest.raises(ValueError, match="Prepares defines prepare"):
        with_all_steps(type("Prepares", (), {"prepare": lambda self, problem: problem}))


def test_a_first_call_that_alone_fails_counts_for_every_solver(monkeypatch, tmp_path) -> None:
    solve, failing = type(find("nsgs")[1]).solve, [True]
    monkeypatch.setattr(type(find("nsgs")[1]), "solve", lambda *given: 0 / 0 if failing and failing.pop() else solve(*given))
    monkeypatch.setattr(worker, "_worker", worker._Worker(Deadline(), None, tmp_path, (), 0, lambda: None), raising=False)
    found = [worker._warm_up("nsgs", dimension, False, 60.0).get("verdict") for dimension in (2, 3)]
    assert found == ["crashed", None]
