"""Problems without a solution: the proof, recomputed from the problem's data in rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest

from frictionbench.harness.cells.collect import collect
from frictionbench.harness.contract.check import in_units, permuted
from frictionbench.harness.plans.plan import Source
from frictionbench.problems import Status
from frictionbench.problems.analysis.contradiction import FAR, contradiction
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.recorded.native import save
from frictionbench.problems.residual import residual
from frictionbench.problems.subproblems import side_by_side
from frictionbench.solvers import solve
from tests.helpers.command_line import frictionbench
from tests.helpers.friction_problems import block, contacts_of, known_by_W, spatial


def between_walls(first=-1.0, second=-0.5, angle=0.7):
    """A point between two walls that ask it to leave with speeds -first and -second, in opposite directions."""
    n, t = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    return contacts_of([n, -n], [t, -t], 0.5, [0.1, 0.0], mass=np.diag([2.0, 2.0]), bias=[first, second])


def exact_sum(problem, found):
    """rho (nv,) and the gain of the weights, in rationals."""
    weights = [*map(Fraction, found.y.tolist()), *map(Fraction, found.z.tolist())]
    rows = np.vstack([problem.normal.toarray(), problem.joints.toarray()]).tolist()
    rho = [sum(w * Fraction(row[v]) for w, row in zip(weights, rows, strict=True)) for v in range(len(problem.free_velocity))]
    offset = np.concatenate([problem.bias, problem.joint_bias]).tolist()
    return rho, -sum(w * Fraction(b) for w, b in zip(weights, offset, strict=True))


@pytest.mark.parametrize("angle", [0.0, 0.7, 1.1])
def test_opposite_walls(angle) -> None:
    problem = between_walls(angle=angle)
    found = contradiction(problem)
    rho, gain = exact_sum(problem, found)
    assert found.y == pytest.approx([1.0, 1.0])
    assert not any(rho)
    assert found.beyond == np.inf
    assert float(gain) == pytest.approx(1.5)
    assert found.least_residual == pytest.approx(1.5 / problem.units.sum(), rel=1e-12)
    assert "conditions of contacts 0, 1 contradict" in str(found)
    assert contradiction(known_by_W(problem)).least_residual == pytest.approx(1.5 / known_by_W(problem).units.sum())
    walls = contacts_of([[1, 0], [-0.6, 0.8], [-0.6, -0.8]], np.eye(3, 2), 0.5, [0, 0], np.diag([1e6, 1e-3]), [-1, -0.1, -0.1])
    assert contradiction(walls).beyond == np.inf  # one of the weights is no power of two of the others
    assert not any(exact_sum(walls, contradiction(walls))[0])


@pytest.mark.parametrize("seed", range(12))
def test_what_has_a_solution_has_no_proof(seed) -> None:
    """The bias of every contact is such that a random velocity leaves all of them, some just so, and moves with the joints,
    one of whose equations is stated twice, with biases that differ by rounding."""
    random = np.random.default_rng(seed)
    for problem in (random_problem(seed, contacts=8), spatial(seed, contacts=8, nv=12, joints=2)):
        v, F = random.standard_normal(len(problem.free_velocity)), problem.joints.toarray()
        twice, rounded = np.vstack([F, 2 * F[:1]]), np.append(np.ones(len(F)), np.full(len(F[:1]), 1 + 4e-16))
        bias = -(problem.normal @ v) + random.choice([0.0, 1.0], problem.contacts)
        reached = problem.replace(bias=bias, joints=twice, joint_bias=-rounded * (twice @ v))
        assert contradiction(reached) is None


@pytest.mark.parametrize("seed", range(12))
def test_proofs_of_random_contacts(seed) -> None:
    """More contacts that all ask for retreat than velocities: recomputed, and the same in other units and another order."""
    made = spatial(seed, contacts=16, nv=6)
    problem = made.replace(bias=-np.random.default_rng(seed).uniform(0.1, 1, 16))
    found = contradiction(problem)
    if found is None:  # a cone of normals that is pointed: there is a velocity along it
        assert seed != 0
        return
    rho, gain = exact_sum(problem, found)
    assert gain > 0
    own = np.abs(problem.free_velocity).max()
    assert float(gain) > FAR * own * float(sum(map(abs, rho))) / 1e3
    assert contradiction(permuted(problem, np.random.default_rng(seed).permutation(16))) is not None
    assert contradiction(in_units(problem, 1e3, 1e-5)) is not None


def test_joint_equations_take_part() -> None:
    """A driven joint pushes a block into the ground with 1 m/s."""
    found = contradiction(block(joints=[[0.0, 1.0]], joint_bias=[1.0]))
    assert found.y.tolist() == [1.0]
    assert found.z.tolist() == [-1.0]
    assert "contact 0 and joint equation 0" in str(found)
    assert contradiction(block(joints=[[0.0, 1.0]], joint_bias=[-1.0])) is None


def test_the_part_that_contradicts_itself_is_named() -> None:
    assert np.flatnonzero(contradiction(side_by_side(block(), between_walls(), block())).y).tolist() == [1, 2]


def test_a_contradiction_of_roundings_size_bounds_the_residual_by_as_little() -> None:
    found = contradiction(between_walls(-1.0, 1.0 - 1e-12))
    assert found is None or found.least_residual < 1e-11


def test_solve_says_so(tmp_path) -> None:
    between_walls_file = tmp_path / "walls.npz"
    problem = between_walls()
    np.savez(between_walls_file, W=problem.W.toarray(), q=problem.q, mu=problem.friction, d=2)
    done = frictionbench("solve", str(between_walls_file), "--solver", "lemke")
    assert "no solution exists: the conditions of contacts 0, 1 contradict each other" in " ".join(done.stdout.split())


@pytest.mark.parametrize("name", ["lemke", "interior_point", "nsgs", "hybrid"])
def test_every_own_method_says_so(name) -> None:
    problem = between_walls()
    answer, proof = solve(problem, name, limit=200), contradiction(problem)
    assert answer.status is Status.INFEASIBLE
    assert answer.detail == str(proof)
    assert residual(problem, answer.impulse) >= proof.least_residual * (1 - 1e-9)


def test_a_limit_alone_proves_nothing() -> None:
    problem = random_problem(3, contacts=8)
    retreats = problem.replace(bias=problem.bias - 1e-3)
    assert (retreats.bias < 0).any()
    assert solve(retreats, "nsgs", tol=1e-12, limit=1).status is Status.WORK_LIMIT


def test_the_problem_is_labelled_where_it_is_collected(tmp_path) -> None:
    for problem, proved in ((between_walls(), True), (block(), False)):
        save(problem, tmp_path / "problem.npz")
        (record,) = collect(tmp_path / str(proved), Source("walls", file=str(tmp_path / "problem.npz")))
        assert record["proved_infeasible"] is proved
        assert (record["existence"] == "none") is proved
