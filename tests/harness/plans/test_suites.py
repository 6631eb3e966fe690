"""What the suites hold: friction at work in every problem, none twice, all sizes in the plane and in space."""

from functools import cache

import numpy as np
import pytest

from frictionbench.harness.cells.collect import collect
from frictionbench.harness.cells.reference import Reference
from frictionbench.harness.cells.stored import stored_friction
from frictionbench.harness.plans import families
from frictionbench.harness.plans.plan import Source
from frictionbench.harness.plans.recorded import every
from frictionbench.harness.plans.suites import COULOMB, IN_SPACE, OUTSIDE, OUTSIDE_LCP, RELAXATION, SUITES
from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.frictionless import idle
from frictionbench.problems.catalogue import instances, make_instance, scene, scenes
from frictionbench.solvers import find, interface, solve
from tests.helpers.frictionless import friction_at_work

MOST = 130  # contacts of problems that are built and solved here; larger ones differ from these in size alone
MOST_LABELLED = 40
CHOSEN = ("smoke", "standard", "scaling", "spatial", "peers")
BANDS = (1, 10, 100, 10**6)
# Of these not even the motion needs friction, or there is none: a pendulum, a ball that bounces straight up and down.
FRICTIONLESS = ("pendulum", "bouncing_ball")
# Not pushed against a wall the jammed disc has many answers, no impulse among them.
SEVERAL_ANSWERS = ("jam",)


@cache
def built(name: str, settings: tuple[tuple[str, float], ...]) -> FrictionProblem:
    return make_instance(name, **dict(settings)) if name in instances() else scene(name, **dict(settings)).problem()


def problem_of(source: Source) -> FrictionProblem:
    return built(source.scene, tuple(source.parameters.items()))


def first_problems(suite: str) -> list[tuple[Source, FrictionProblem]]:
    """The problems of a suite that need no motion."""
    found = [(source, problem_of(source)) for source in SUITES[suite]().sources if not source.pick]
    return [(source, problem) for source, problem in found if problem.contacts <= MOST]


@pytest.mark.parametrize("suite", CHOSEN)
def test_friction_is_at_work_in_every_problem(suite: str) -> None:
    assert [source for source, problem in first_problems(suite) if not friction_at_work(problem)] == []


@pytest.mark.parametrize("suite", ["smoke", "standard", "spatial"])
def test_the_label_agrees(suite: str) -> None:
    """On every third problem, and on it without friction at every second contact."""
    for _, problem in [one for one in first_problems(suite) if one[1].contacts <= MOST_LABELLED][::3]:
        smooth = problem.replace(friction=problem.friction * (np.arange(problem.contacts) % 2))
        assert idle(problem, Reference()) == (not friction_at_work(problem))
        assert idle(smooth, Reference()) == (not friction_at_work(smooth))


@pytest.mark.parametrize("source", [Source("two_blocks", {"friction": 0.1}, 2), Source("long_bar", {"friction": 0.2}, 2)])
def test_friction_is_at_work_in_the_chosen_steps(source: Source, tmp_path) -> None:
    records = collect(tmp_path, source)
    assert len(records) == 2
    assert all(friction_at_work(stored_friction(tmp_path, record["problem"])) for record in records)


@pytest.mark.parametrize("suite", CHOSEN)
def test_no_problem_is_in_a_suite_twice(suite: str) -> None:
    """Two problems are the same if their bodies take up the same momentum, up to a factor."""
    taken: dict[tuple[str, int], list[np.ndarray]] = {}
    for source, problem in first_problems(suite):
        momentum = problem.jacobian.T @ solve(problem, "hybrid", tol=1e-8).impulse.ravel()
        momentum /= np.abs(momentum).max()
        others = taken.setdefault((source.scene, len(momentum)), [])
        assert not any(np.allclose(momentum, known, atol=1e-5) for known in others), source
        others.append(momentum)


@pytest.mark.parametrize("name", sorted(scenes().keys() | instances().keys()))
def test_friction_is_at_work_at_the_defaults(name: str) -> None:
    problem = built(name, ())
    if name in SEVERAL_ANSWERS or not problem.contacts:
        assert name in (*SEVERAL_ANSWERS, *FRICTIONLESS) or scenes()[name].parameters["friction"] > 0
    else:
        assert friction_at_work(problem)


def test_families_have_as_many_problems_of_each_size() -> None:
    for bands, dimension in ((families.PLANE, 2), (families.SPACE, 3)):
        for band, low, high in zip(bands, (0, *BANDS), BANDS, strict=False):
            assert band
            for source in families.sources(band):
                problem = problem_of(source)
                assert problem.dimension == dimension
                assert low < problem.contacts <= high
    sources = families.sources(*families.PLANE, *families.SPACE)
    assert len(set(map(repr, sources))) == len(sources)
    assert len(families.halves(*families.PLANE, *families.SPACE)) == len(sources) / 2


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("band", [1, 2])  # those of several contacts, up to a hundred
def test_contacts_stick_slide_and_open(band: int, dimension: int) -> None:
    """In each band a tenth of all contacts and more stick, as many slide, and some problems do only one of them."""
    sticking, sliding = [], []
    for source in families.sources((families.PLANE if dimension == 2 else families.SPACE)[band]):
        problem = problem_of(source)
        r = solve(problem, "hybrid", tol=1e-8).impulse
        u, unit = problem.contact_velocity(r), 1e-6 * problem.velocity_scale
        bears = problem.scale * np.abs(r).max(axis=1) > unit
        slips = np.linalg.norm(u[:, 1:], axis=1) > unit
        sticking.append(np.mean(bears & ~slips))
        sliding.append(np.mean(bears & slips))
    for shares in (sticking, sliding):
        assert np.mean(shares) > 0.1
        assert 0.0 in shares


def test_no_solver_of_a_lineup_can_only_refuse() -> None:
    for suite, make in SUITES.items():
        plan = make()
        for dimension in (3,) if suite in ("spatial", "robots") else (2, 3)[: 1 + bool(plan.spatial_solvers)]:
            assert all(dimension in find(spec)[0].dimension for spec in plan.lineup(dimension)), suite
    assert {"proximal_newton", "nsgs", "interior_point", "clarabel[settings=default]"} <= set(every(3))
    assert not {"osqp", "piqp[matrices=dense]"} & set(every(3))


def test_standard_takes_in_outside_solvers_that_are_installed(monkeypatch) -> None:
    """Of Coulomb's law: where no library is installed, only our own methods and those of the relaxation."""
    pinocchio, path = ("pinocchio[method=admm,settings=tuned]",), ("path[settings=tuned]",)
    for packages, both, planar in (((), (), ()), (("gamspy",), (), path), (("pin", "drake"), pinocchio, ())):
        monkeypatch.setattr(interface, "installed_version", lambda need, given=packages: "1" if need in given else None)
        for plan in (SUITES["standard"](), SUITES["sealed"]()):
            assert plan.solvers == (*COULOMB, *RELAXATION, *both, *planar)
            assert plan.spatial_solvers == (*IN_SPACE, *both)
            assert (plan.expects == "four minutes") == (not packages)
    assert {find(spec)[0].model for spec in OUTSIDE} == {"coulomb"}
    assert {find(spec)[0].model for spec in OUTSIDE_LCP} == {"lcp"}
