"""Many problems at once: the impulses, statuses and counts of one by one, to the last bit."""

import numpy as np
import pytest

import frictionbench as fb
from frictionbench.problems import FrictionProblem
from frictionbench.problems.packed import Packed
from frictionbench.solvers import many
from frictionbench.solvers.interface import Solved, find
from tests.helpers.friction_problems import known_by_W

LOOPED = ("lemke", "nsgs", "interior_point", "hybrid")


@pytest.fixture(scope="module")
def planar() -> list[FrictionProblem]:
    """Stacks of several sizes, one without contacts, one known by W, one with joints, and two islands of unlike speeds."""
    stacks = [fb.scene("stack", blocks=n, push=1.0).problem() for n in (1, 3, 2)]
    known = FrictionProblem.from_delassus(stacks[1].W, stacks[1].q, stacks[1].friction, 2)
    apart = FrictionProblem.from_delassus(np.eye(4), [-1.0, 0.3, -1e-3, 1e-3], [0.5, 0.5], 2)
    empty = FrictionProblem.from_delassus(np.zeros((0, 0)), [], [], 2)
    joined = fb.scene("chain", links=3).problem()
    return [*stacks, empty, known, apart, joined]


@pytest.fixture(scope="module")
def spatial() -> list[FrictionProblem]:
    """Spheres and cubes, with W only as well; hybrid and nsgs leave the last but one to the interior point."""
    spheres, cubes = fb.instance("sphere_pyramid", levels=2), fb.instance("cubes", boxes=1)
    known = known_by_W(spheres)
    left = (
        fb.instance("cubes", boxes=1, friction=0.8, twist=3.0),
        fb.instance("cubes", boxes=2, fall=0.0, friction=3.0, twist=8.0),
    )
    return [spheres, cubes, known, *left, fb.instance("cubes", boxes=2)]


def assert_as_one_by_one(
    problems: list[FrictionProblem], spec: str, workers: int, start: list[np.ndarray] | None = None, limit: int | None = None
) -> None:
    answers = fb.solve_many(problems, spec, workers=workers, start=start, limit=limit)
    for k, problem in enumerate(problems):
        answer = fb.solve(problem, spec, start=None if start is None else start[k], limit=limit)
        np.testing.assert_array_equal(answers[k], answer.impulse)
        assert answers.status[k] is answer.status
        assert {name: answers.work[name][k] for name in answer.work} == answer.work
        assert answers.residual[k] == fb.residual(problem, answer.impulse)
        assert answers.floor[k] == fb.residual_floor(problem, answer.impulse)


@pytest.mark.parametrize("spec", LOOPED)
def test_same_as_one_by_one(spec: str, planar: list[FrictionProblem], spatial: list[FrictionProblem]) -> None:
    for limit in (None, 4):
        assert_as_one_by_one([*planar, *spatial], spec, workers=1, limit=limit)


@pytest.mark.parametrize("spec", LOOPED)
def test_loops_leave_next_to_nothing(spec: str, planar: list[FrictionProblem]) -> None:
    """What a loop leaves is solved one by one, so that the answers alone do not show that there is a loop."""
    batch = fb.Batch(planar[:3])
    ((_, packed),) = batch.groups
    np.testing.assert_array_equal(fb.solve_many(batch, spec).impulse, fb.solve_many(planar[:3], spec).impulse)
    found = find(spec)[1].solve_many(packed, 1e-8, None)  # type: ignore[attr-defined]
    assert found.status.tolist() == [fb.Status.SOLVED] * 3


def test_hybrid_goes_from_newtons_method_to_the_interior_point(spatial: list[FrictionProblem]) -> None:
    ((_, packed),) = fb.Batch(spatial[3:]).groups
    found = find("hybrid")[1].solve_many(packed, 1e-8, None)  # type: ignore[attr-defined]
    assert found.work["members"].tolist() == [1, 2, 1]
    assert (found.work["interior_point iterations"] > 0).tolist() == [False, True, False]
    assert "members" in fb.solve_many(spatial[3:]).work  # without a name hybrid, as in solve


@pytest.mark.parametrize("spec", ["lemke", "nsgs", "interior_point"])
def test_loops_start_at_the_answers_of_before(spec: str, planar: list[FrictionProblem]) -> None:
    cold = fb.solve_many(planar[:3], spec)
    for start in (cold, cold.impulse, list(cold)):
        warm = fb.solve_many(planar[:3], spec, start=start)
        assert warm.solved.all()
        assert sum(counts.sum() for counts in warm.work.values()) < sum(counts.sum() for counts in cold.work.values())
    with pytest.raises(fb.InputError, match="start: expected impulses of 2 problems, got 3"):
        fb.solve_many(planar[:2], spec, start=cold)
    with pytest.raises(IndexError, match="3 is not the number of one of 3 problems"):
        cold[3]
    loop = find(spec)[1].solve_many(fb.Batch(planar[:3]).groups[0][1], 1e-8, None, cold.impulse.reshape(-1, 2))  # type: ignore[attr-defined]
    assert loop.status.tolist() == [fb.Status.SOLVED] * 3


def anything(rng: np.random.Generator) -> list[FrictionProblem]:
    """Problems of mixed sizes in mixed order, in the plane and in space, by bodies and by W: some without solution."""
    squeezed = np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 1.0], [-1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0]])
    problems = [
        FrictionProblem.from_delassus(squeezed, [-1.0, 0.3, -1.0, 0.3], [0.5, 0.5], 2),  # two walls close in on a body
        *(FrictionProblem.from_delassus(np.zeros((0, 0)), [], [], d) for d in (2, 3)),
    ]
    for _ in range(4):
        push, mu = rng.uniform(0, 2), rng.choice([0.0, rng.uniform(0.01, 2)])
        stack = {"blocks": int(rng.integers(1, 6)), "push": push, "mass_ratio": 10 ** rng.uniform(-2, 2)}
        problems.append(fb.scene("stack", **stack, friction=mu).problem())
        cubes = {"boxes": int(rng.integers(1, 3)), "push": push, "twist": rng.uniform(0, 2), "fall": 1.0}
        problems.append(fb.instance("cubes", **cubes, friction=mu))
        for d in (2, 3):
            nc = int(rng.integers(1, 7))
            A = rng.normal(size=(nc * d, int(rng.integers(1, nc * d + 3))))
            mu = rng.choice([0.0, 0.3, 1.0], nc)
            problems.append(FrictionProblem.from_delassus(A @ A.T, rng.normal(size=nc * d), mu, d))
    return [problems[k] for k in rng.permutation(len(problems))]


@pytest.mark.parametrize("spec", LOOPED)
def test_anything_is_as_one_by_one(spec: str) -> None:
    rng = np.random.default_rng(LOOPED.index(spec))
    problems = anything(rng)
    start = [rng.normal(size=(problem.contacts, problem.dimension)) for problem in problems]
    for given in (None, start):
        assert_as_one_by_one(problems, spec, workers=int(rng.integers(1, 4)), start=given, limit=60)


class Plugin:
    """Gives no impulses in its own loop, of a shape, and leaves the last problem to `solve`."""

    def __init__(self, missing: int) -> None:
        self.missing = missing

    def solve_many(self, packed: Packed, tol: float, limit: int | None) -> Solved:
        status = np.array([fb.Status.FAILED] * (packed.size - 1) + [None])
        impulse = np.zeros((packed.contacts[-1] - self.missing, packed.dimension))
        return Solved(impulse, status, {"passes": np.ones(packed.size, np.int64)})


@pytest.mark.parametrize("missing", [0, 1])
def test_a_solver_may_have_its_own_loop(missing: int, planar: list[FrictionProblem], monkeypatch: pytest.MonkeyPatch) -> None:
    info = fb.available()["murty"]
    monkeypatch.setattr(many, "find", lambda spec: (info, Plugin(missing)))
    if missing:
        with pytest.raises(fb.InputError, match="solve_many: must return impulses of shape"):
            fb.solve_many(planar[:2], "murty")
        return
    answers = fb.solve_many(planar[:2], "murty")
    assert answers.status.tolist() == [fb.Status.FAILED, fb.solve(planar[1], "murty").status]
    assert (answers.residual[0], answers.solved.tolist()) == (fb.residual(planar[0], answers[0]), [False, True])
    assert answers.work["passes"].tolist() == [1, 1]


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"problems": [3]}, r"problems\[0\]"),
        ({"spec": "lemk"}, "solver"),
        ({"spec": "proximal_newton"}, "problems"),  # of contacts in space
        ({"tol": 0.0}, "tol"),
        ({"workers": 0}, "workers"),
        ({"start": 3}, "start: must be"),
        ({"start": [np.zeros((2, 2)), np.zeros((3, 2))]}, r"start\[1\]: expected"),
        ({"start": np.full(16, np.nan)}, "start: must be finite"),
    ],
)
def test_invalid_arguments(arguments: dict[str, object], named: str, planar: list[FrictionProblem]) -> None:
    given: dict[str, object] = {"problems": planar[:2], "spec": "lemke"} | arguments
    with pytest.raises(fb.InputError, match=named):
        fb.solve_many(given.pop("problems"), given.pop("spec"), **given)  # type: ignore[arg-type]
