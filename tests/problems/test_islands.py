"""The islands of the contact graph and the velocities in which residuals are measured."""

import numpy as np
import pytest

from frictionbench.harness.contract.check import in_units, permuted
from frictionbench.problems.analysis.stability import backward_error
from frictionbench.problems.catalogue import scene
from frictionbench.problems.forms.islands import CANCELLED, COUPLED, FAR, NOISE
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import polygon_residual, relaxation_residual, residual, residual_floor
from frictionbench.problems.subproblems import side_by_side
from frictionbench.solvers import solve
from tests.helpers.friction_problems import block, contacts_of, known_by_W, spatial, with_joints


def by_definition(problem, terms):
    """The units of contacts that all have a normal and tangents, from the definition: every set written out.

    terms: (nc,), the size of the terms of q_i."""
    nc, d = problem.contacts, problem.dimension
    share = np.linalg.norm(problem.W.toarray().reshape(nc, d, nc, d), axis=(1, 3)) / problem.scale  # of j's velocity, to i
    q, s = problem.q.reshape(nc, d), problem.scale
    size, linked = np.maximum(np.linalg.norm(q, axis=1), CANCELLED * terms), share > COUPLED
    biased = np.minimum(np.linalg.norm(q[:, 1:], axis=1), s * problem.friction_bias)
    demand = np.maximum(np.maximum(-q[:, 0], 0.0), biased)
    closes = q[:, 0] <= NOISE * size

    def islands(among):
        links = (linked | linked.T) & np.outer(among, among)
        return np.linalg.matrix_power(links * 1.0 + np.eye(nc), nc) > 0

    given = np.sqrt(s * (islands(np.ones(nc, bool)) @ (np.where(closes, size, demand) ** 2 / s)))
    bears = closes | (q[:, 0] <= FAR * given) | (s * problem.friction_bias > COUPLED * given)
    cut = np.maximum(np.maximum(demand, CANCELLED * terms), np.where(q[:, 0] <= FAR * given, np.minimum(size, FAR * given), 0))
    speed, mattering = np.where(closes, size, cut), np.where(closes, terms, cut)
    island, unit = islands(bears), np.zeros(nc)
    for i in np.flatnonzero(bears):
        needed, fastest, largest = (value[island[i]].max() for value in (demand, speed, mattering))
        unit[i] = max(needed if needed > NOISE * largest else fastest, CANCELLED * largest)
    for i in np.flatnonzero(~bears):
        pushing = unit[bears & linked[i]]
        unit[i] = pushing.min() if len(pushing) else np.linalg.norm(q[i])
    return np.where(bears, np.maximum(unit, CANCELLED * terms), unit)


def sizes(problem):
    """(nc,): |q_i| and the size of the terms of q_i, |b_i| + sum_v |J_iv| |v_v|."""
    nc, d = problem.contacts, problem.dimension
    levers = np.linalg.norm(problem.jacobian.toarray().reshape(nc, d, -1), axis=1)
    return np.linalg.norm(problem.q.reshape(nc, d), axis=1), np.abs(problem.bias) + levers @ np.abs(problem.free_velocity)


def cases(seed):
    random = np.random.default_rng(seed)
    problem = (
        random_problem(seed, contacts=int(random.integers(1, 9)), friction=0.5)
        if seed % 2
        else spatial(seed, contacts=int(random.integers(1, 7)), nv=30)
    )
    gaps = np.where(random.random(problem.contacts) < 0.3, 10 ** random.uniform(-1, 8, problem.contacts), 0.0)
    return problem.replace(bias=problem.bias + gaps)


@pytest.mark.parametrize("seed", range(30))
def test_units_by_definition(seed) -> None:
    problem = cases(seed)
    speed, terms = sizes(problem)
    assert known_by_W(problem).units == pytest.approx(by_definition(problem, speed), rel=1e-9)
    assert problem.units == pytest.approx(by_definition(problem, terms), rel=1e-9)


def test_no_impulses_have_the_residual_1_of_either_law() -> None:
    """A belt of 1e3 m/s: what the relaxation has to lift, 500 m/s, is no measure of what Coulomb's law has to change."""
    problem = block(speed=1e3, friction=0.5)
    for given in (problem, known_by_W(problem)):
        closing = -given.q[0]
        assert given.units == pytest.approx([max(closing, CANCELLED * 1e3)])
        assert given.relaxation_units == pytest.approx([closing + 500])
        assert relaxation_residual(given, np.zeros((1, 2))) == pytest.approx(1 / np.hypot(1, 0.5), rel=0.2)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("convert", [lambda problem: problem, known_by_W], ids=["bodies", "W"])
def test_measures_of_problems_side_by_side_are_the_largest_of_theirs(seed, convert) -> None:
    random, dimension = np.random.default_rng(seed), 2 + seed % 2
    parts, impulses = [], []
    for number in range(3):
        made = random_problem(3 * seed + number, contacts=4) if dimension == 2 else spatial(3 * seed + number, contacts=4)
        mass, velocity = 10 ** random.uniform([-8, -6], [8, 6])  # units within 1e14 of one another
        parts.append(in_units(made, mass, velocity))
        off = 1 + 10 ** random.uniform(-9, -1) * random.standard_normal((made.contacts, dimension))
        impulses.append(mass * velocity * off * solve(made, "hybrid", tol=1e-12).impulse)
    whole, together = convert(side_by_side(*parts)), np.vstack(impulses)
    for measure in (residual, relaxation_residual, residual_floor, backward_error):
        alone = max(measure(convert(part), r) for part, r in zip(parts, impulses, strict=True))
        assert measure(whole, together) == pytest.approx(alone, rel=1e-6)


def test_islands_are_numbered_and_counted() -> None:
    two = side_by_side(scene("stack", blocks=2).problem(), block())
    for problem in (two, known_by_W(two)):
        assert problem.islands.tolist() == [0, 0, 0, 0, 1]
    assert with_joints(side_by_side(block(), block()), [[1.0, 0.0, -1.0, 0.0]]).islands.tolist() == [0, 0]


def test_a_contact_at_rest_on_moving_bodies_is_measured_by_rounding_of_their_speed() -> None:
    """A block that moves with 1e3 m/s and touches with 1e-14: no solver can find that from its data."""
    problem = block(speed=0.0).replace(free_velocity=[0.0, 1e3], bias=[-1e3])
    assert problem.units == pytest.approx([1e-6 * 2e3])
    assert residual(problem, np.zeros((1, 2))) == 0


def test_an_island_without_velocity_takes_the_unit_of_the_others() -> None:
    still = block().replace(free_velocity=[0.0, 0.0])
    problem = side_by_side(still, block())
    assert problem.units[0] == problem.units[1] > 0
    assert residual(problem, solve(problem, "lemke").impulse) <= 1e-8
    assert still.units.tolist() == [0.0]
    assert residual(still, np.zeros((1, 2))) == 0
    assert residual(still, np.ones((1, 2))) == pytest.approx(1.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_balanced_islands_are_alike_and_have_the_same_answers(dimension) -> None:
    parts = [random_problem(5 + k, 5) if dimension == 2 else spatial(5 + k, joints=k % 2) for k in range(3)]
    problem = side_by_side(*(in_units(part, 1.0, 10 ** (4.5 * k)) for k, part in enumerate(parts)))
    for given in (problem, known_by_W(problem)):
        same, factor = given.balanced()
        assert given.spread > 1e8
        fastest = [same.units[same.islands == island].max() for island in set(same.islands.tolist())]
        assert max(fastest) <= 2 * min(fastest)
        r = np.random.default_rng(0).uniform(0, 1, (problem.contacts, dimension))
        moved = given.contact_velocity(r * factor[:, None])
        assert moved == pytest.approx(same.contact_velocity(r) * factor[:, None], rel=1e-7)
        assert residual(given, r * factor[:, None]) == pytest.approx(residual(same, r), rel=1e-9)


def test_contacts_that_are_open_by_as_much_do_not_count_as_energy() -> None:
    resting = block(speed=0.0)
    twice = permuted(resting, np.array([0, 0, 0])).replace(bias=[0.0, 1e6, 1e6])
    for problem in (twice, known_by_W(twice)):
        assert problem.units[0] == pytest.approx(resting.velocity_scale)
        assert residual(problem, np.zeros((3, 2))) == pytest.approx(1.0)


def test_a_sliding_contact_whose_bias_is_rounding_can_be_judged() -> None:
    """In the second phase of Poisson's law, a block that slides opens by rounding and keeps a friction bias of rounding."""
    sliding = block(speed=3.4).replace(free_velocity=[3.4, 1.6e-8], friction_bias=[1.5e-10])
    for problem in (sliding, known_by_W(sliding)):
        answer = solve(problem, "interior_point", tol=1e-8)
        assert residual_floor(problem, answer.impulse) < 1e-8
        assert answer.status.name == "SOLVED"


@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 4])
def test_a_locked_tangent_is_no_diagonal_of_the_lcp(angle) -> None:
    """Rounding of a diagonal that vanishes misled the scaling, and with it the claims, of methods on the LCP."""
    locked = [[0.0, np.cos(angle), np.sin(angle)]]
    problem = contacts_of(
        [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 0.5, [-0.1, 1.0, 0.3], joints=locked, joint_bias=[0.5]
    )
    diagonal = problem.lcp().dense.diagonal()
    assert ((diagonal == 0) | (diagonal > 1e-3)).all()
    for name in ("lemke", "path_search", "fischer_newton", "minmap_newton", "dantzig", "murty"):
        answer = solve(problem, name)
        assert answer.status.name != "SOLVED" or polygon_residual(problem, problem.lcp(), answer.z) <= 1e-8
