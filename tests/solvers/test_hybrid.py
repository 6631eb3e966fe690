"""hybrid: which member comes first, and when an answer is within rounding."""

from collections.abc import Callable

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.cubes import cubes
from frictionbench.problems.instances.random_bodies import random_bodies, random_problem
from frictionbench.problems.instances.rod_chain import rod_chain
from frictionbench.problems.residual import residual_floor
from frictionbench.solvers import clock, hybrid
from frictionbench.solvers.interface import Answer, Status, find, solve
from frictionbench.solvers.many import solve_many
from tests.helpers.friction_problems import known_by_W, nothing

FIRST_BY_PIVOTS = {
    **{f"random, {contacts} contacts": (random_problem(1, contacts), first) for contacts, first in ((30, True), (50, False))},
    "a stack with one body pushed": (scene("stack", blocks=18, push=1.0).problem(), True),
    "a long stack": (scene("stack", blocks=40, push=1.0).problem(), False),
    "a pyramid": (scene("pyramid", rows=5).problem(), False),
}


@pytest.mark.parametrize("name", FIRST_BY_PIVOTS)
def test_pivots_come_first_in_small_problems(name: str) -> None:
    problem, first = FIRST_BY_PIVOTS[name]
    answer = solve(problem, "hybrid")
    assert (answer.status, "lemke pivots" in answer.work) == (Status.SOLVED, first)


@pytest.mark.parametrize("warm", [False, True])
@pytest.mark.parametrize("name", ["none", "free", "known by W", "pushed", "random"])
def test_one_call_finds_what_lemke_finds(name: str, warm: bool) -> None:
    """The impulses to the last bit, and the counts of its work."""
    pushed = scene("stack", blocks=5, push=1.0).problem()
    free = FrictionProblem.from_delassus(np.eye(2), [1.0, 0.5], [0.5], d=2)
    problem = {"none": nothing(), "free": free, "known by W": known_by_W(pushed), "random": random_problem(1, 30)}.get(
        name, pushed
    )
    start = 0.9 * solve(problem, "lemke").impulse if warm else None
    _, lemke = find("lemke")
    at_once, alone = solve(problem, "hybrid", start=start), lemke.solve(lemke.prepare(problem), 1e-8, None, start)
    np.testing.assert_array_equal(at_once.impulse, alone.impulse)
    assert at_once.work == {"members": 1} | {f"lemke {unit}": count for unit, count in alone.work.items()}


def test_pivots_come_before_the_paths_of_a_trapped_interior_point() -> None:
    answer = solve(random_problem(304, 60), "hybrid")
    assert (answer.detail, answer.work["interior_point factorisations"] < 40) == ("answered by lemke", True)  # paths take 160


def test_packed_problems_take_the_same_member_first() -> None:
    problems = [*(problem for problem, _ in FIRST_BY_PIVOTS.values()), known_by_W(scene("stack", push=1.0).problem())]
    pivoted = solve_many(problems, "hybrid").work["lemke pivots"] > 0
    np.testing.assert_array_equal(pivoted, [first for _, first in FIRST_BY_PIVOTS.values()] + [True])


def test_a_claim_within_the_floor_of_rounding_is_an_answer() -> None:
    """A block of 1e10 times the mass of the one below it: rounding hides any residual below 1e-6."""
    answer = solve(scene("stack", blocks=4, mass_ratio=1e10, push=1.0).problem(), "hybrid")
    assert (answer.status, answer.work["members"]) == (Status.ROUNDING, 2)  # their floors are alike: the problem's


def test_huge_impulses_do_not_explain_a_failure_by_rounding() -> None:
    """A contact into which friction presses the body: no impulses solve it, and of huge ones the residual is hidden."""
    wedge = FrictionProblem(
        dimension=3, mass=np.eye(2), normal=[[-0.6, 0]], tangent=np.eye(2), friction=[10], free_velocity=[0.5, 0.1], bias=[-0.2]
    )
    assert solve(wedge, "hybrid").status is Status.STALLED


def test_smaller_impulses_are_looked_for_where_rounding_hides_the_residual() -> None:
    """A finger of a gripper that slides along the floor: of its normal only rounding acts, and 1e14 N s would hold it."""
    finger = FrictionProblem(
        dimension=3, mass=np.diag([0.4, 1.2]), normal=[[0, 3e-16], [1, 1]], tangent=[[0, 0], [0, 1], [0, 0], [0, 0]],
        friction=[1, 1], free_velocity=[-0.06, -1], bias=[0, 0],
    )  # fmt: skip
    for answer in (solve(finger, "hybrid"), solve_many([finger], "hybrid")):
        assert residual_floor(finger, answer.impulse.reshape(-1, 3)) < 1e-12
        assert np.all(answer.status == Status.SOLVED)


def test_newtons_method_is_first_where_contacts_in_space_are_few() -> None:
    """Not of cubes in a long stack, whose W is singular, unless only W is known."""
    problems = rod_chain(links=20), cubes(3), cubes(4), known_by_W(cubes(4))
    assert ["newton steps" in solve(problem, "hybrid").work for problem in problems] == [True, True, False, True]


def test_contradictions_are_not_looked_for_after_a_few_sweeps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("frictionbench.solvers.hybrid.contradiction", lambda problem: pytest.fail("looked for"))
    answer = solve(known_by_W(cubes(20)), "hybrid")
    assert (answer.detail, 0 < answer.work["nsgs sweeps"] <= 30) == ("answered by interior_point", True)


@pytest.mark.parametrize("problem", [known_by_W(scene("chain", links=70, fall=1.0).problem()), random_bodies(contacts=120)])
def test_sweeps_go_on_while_they_converge_quickly(problem: FrictionProblem) -> None:
    answer = solve(problem, "hybrid")
    assert (answer.status, answer.detail) == (Status.SOLVED, "answered by nsgs")
    np.testing.assert_array_equal(solve_many([problem], "hybrid")[0], answer.impulse)


@pytest.mark.parametrize(
    ("problem", "members"),
    [
        (random_problem(1, 4), ("at once", "begin", "nsgs", "interior_point", "staggered")),
        (random_problem(1, 40), ("begin", "lemke", "nsgs", "interior_point", "staggered")),
        (scene("stack", blocks=60, push=1.0).problem(), ("interior_point", "lemke", "nsgs", "staggered")),
        (cubes(4), ("begin", "nsgs", "proximal_newton", "interior_point", "proximal_newton", "apgd_coulomb")),
        (cubes(26), ("interior_point", "nsgs", "proximal_newton", "apgd_coulomb")),
    ],
)
def test_members_share_a_time_limit(problem, members: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """On a clock that stands still, so that no member uses any of its time; the last one has all of it."""
    monkeypatch.setattr(clock, "_now", lambda: 100.0)
    given: list[tuple[str, float]] = []

    def stalled(name: str) -> Callable[..., Answer]:
        def solve(self: object, prepared: object, tol: float, limit: int | None, start: object = None) -> Answer:
            given.append((name, clock.left()))
            return Answer(np.zeros((problem.contacts, problem.dimension)), Status.STALLED)

        return solve

    def stalled_at_once(*_: object) -> tuple[np.ndarray, float, float, dict[str, int]]:
        given.append(("at once", clock.left()))
        return np.zeros((problem.contacts, problem.dimension)), 1.0, 0.0, {}

    monkeypatch.setattr(hybrid, "lemke_at_once", stalled_at_once)
    for name in set(members) - {"at once"}:
        of, step = ("interior_point", "begin") if name == "begin" else (name, "solve")
        monkeypatch.setattr(type(find(of)[1]), step, stalled(name))
    assert solve(problem, "hybrid", time_limit=10.0).work["members"] == len(members)
    assert given == [*((name, pytest.approx(9.0)) for name in members[:-1]), (members[-1], pytest.approx(10.0))]


def test_proximal_points_solve_a_wall_that_stops_the_interior_point(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here after one factorisation, which stands for the 16 000 that some walls of boxes take."""
    for step in ("begin", "solve"):
        monkeypatch.setattr(type(find("interior_point")[1]), step, lambda *_: Answer(np.zeros((16, 3)), Status.STALLED))
    assert solve(cubes(4, push=1.0), "hybrid").detail == "answered by proximal_newton"


def test_walls_on_both_sides_contradict_each_other_after_newtons_method() -> None:
    x, law = np.eye(3), {"friction": [0.5, 0.5], "free_velocity": [0, 1, 0], "bias": [-1, -0.5]}
    answer = solve(FrictionProblem(dimension=3, mass=x, normal=[x[0], -x[0]], tangent=x[[1, 2, 1, 2]], **law), "hybrid")
    assert (answer.status, answer.work["members"]) == (Status.INFEASIBLE, 2)


def test_nothing_is_formed_without_contacts() -> None:
    v, row = np.arange(3.0), np.zeros((0, 3))
    law = {"friction": row[:, 0], "bias": row[:, 0], "normal": row, "tangent": row, "dimension": 3}
    given = FrictionProblem(mass=np.eye(3), free_velocity=v, joints=[v], joint_bias=[1.0], **law)
    assert (given.contacts, solve(given, "hybrid").status) == (0, Status.SOLVED)
    assert not {"W", "blocks"} & vars(given).keys()
