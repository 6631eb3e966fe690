"""The residual where one of its terms hides behind another, or numbers are very large or small."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.answer import Answer, Status
from frictionbench.problems.forms.islands import CANCELLED, NOISE
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import relaxation_residual, residual, residual_floor
from frictionbench.problems.verdicts import Verdict
from frictionbench.problems.verify import verify
from tests.helpers.friction_problems import block, contacts_of

contact_space = FrictionProblem.from_delassus
NEIGHBOURS = np.eye(4) + 0.1 * np.kron([[0, 1], [1, 0]], np.eye(2))


def nothing(problem):
    return residual(problem, np.zeros((problem.contacts, problem.dimension)))


@pytest.mark.parametrize("friction", [10.0, 1e4, 1e8, 1e12])
def test_a_large_friction_does_not_hide_penetration(friction) -> None:
    assert nothing(contact_space(np.eye(2), [-1.0, 1e3], [friction], 2)) == pytest.approx(1.0)
    assert nothing(random_problem(1, contacts=12, friction=friction)) > 0.1


@pytest.mark.parametrize("friction", [10.0, 1e6])
def test_a_large_friction_does_not_hide_an_impulse_on_an_open_contact(friction) -> None:
    """r lies on the cone's edge against the slip, so that the cone formulation counts u_n as u_n/sqrt(1 + mu^2)."""
    normal = 1.0 / friction
    problem = contact_space(np.eye(2), [0.5 - normal, 2.0], [friction], 2)
    assert residual(problem, np.array([[normal, -1.0]])) == pytest.approx(min(normal, 0.5) / problem.units[0])


def test_signorini_s_law_is_not_asked_of_the_relaxation() -> None:
    """A sliding contact of the convex relaxation opens with mu |u_t|: r = 0 where q_n = mu |q_t| is optimal."""
    problem = contact_space(np.eye(2), [-0.5, 1.0], [0.5], 2)
    normal = 0.5 / 1.25  # the optimum of r'r/2 + q'r on r_t = -mu r_n: (1 + mu^2) r_n = mu |q_t| - q_n
    slides = np.array([[2 * normal, -normal]])
    assert relaxation_residual(problem, slides) <= 1e-15
    assert residual(problem, slides) > 0.1


def belt():
    """A ball on the ground below a belt that is nearly out of reach and moves with 200 m/s."""
    return contacts_of(
        [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]],
        [[1.0, 0.0, 0.0], [1.0, 0.0, -1.0]],
        0.5,
        [5e-3, -1e-2, 200.0],
        mass=np.diag([1.0, 1.0, 1e3]),
        bias=[0.0, 0.05],
    )


@pytest.mark.parametrize(
    "problem",
    [
        contact_space(NEIGHBOURS, [-1e-3, 0.5e-3, 5e-3, 1e6], [0.5, 0.5], 2),
        contact_space(NEIGHBOURS, [-1e-3, 0.5e-3, 1e9, 0.0], [0.5, 0.5], 2, [0.0, 1e-300]),
        belt(),
    ],
    ids=["slides fast", "tiny friction bias", "belt"],
)
def test_a_fall_does_not_hide_behind_a_contact_that_opens(problem) -> None:
    assert nothing(problem) >= 0.999e-3
    assert residual_floor(problem, np.zeros((2, 2))) < 1e-12


@pytest.mark.parametrize("size", [1e-320, 1e-300, 1e-162, 1e155, 1e200, 1e300])
@pytest.mark.parametrize("dimension", [2, 3])
def test_squares_neither_overflow_nor_vanish(size, dimension) -> None:
    falling = np.zeros(dimension)
    falling[0] = -size
    problem = contact_space(np.eye(dimension), falling, [0.5], dimension)
    assert nothing(problem) == pytest.approx(1.0)
    assert residual(problem, -falling[None]) == 0
    assert nothing(contact_space(np.eye(dimension), -size * np.ones(dimension), [0.5], dimension)) > 0.5


@pytest.mark.parametrize(("speed", "step"), [(10.0, 1e-4), (100.0, 1e-3), (10.0, 0.01)])
def test_a_sliding_block_needs_its_support(speed, step) -> None:
    problem = block(speed, h=step)
    assert nothing(problem) == pytest.approx(1.0)
    assert verify(problem, Answer(np.zeros((1, 2)), Status.SOLVED), "coulomb", 1e-4).verdict == Verdict.WRONG


def hinge(coordinate):
    """A block on the ground, and a limit of an angle (rad) that closes, with the unit of angle in rad."""
    rows = np.array([[0.0, 1.0, 0.3], [0.0, 0.0, 1.0 / coordinate]])
    return contacts_of(rows, [[1.0, 0.0, 0.1], [0.0, 0.0, 0.0]], [0.5, 0.0], [0.3, -0.02, -2.0], mass=np.diag([1.0, 1.0, 0.02]))


@pytest.mark.parametrize("coordinate", [np.pi / 180, 1e3, 1e-6])
def test_a_joint_s_coordinate_changes_no_residual(coordinate) -> None:
    impulse = np.array([[0.01, 0.002], [0.03, 0.0]])
    other = impulse * [[1.0], [coordinate]]
    for turn in (lambda p: p, lambda p: contact_space(p.W, p.q, p.friction, 2)):
        assert residual(turn(hinge(coordinate)), other) == pytest.approx(residual(turn(hinge(1.0)), impulse), rel=1e-9)


@pytest.mark.parametrize("mass", [1e-3, 1e4])
def test_a_row_of_nothing_has_the_scale_of_the_others(mass) -> None:
    """The unit of mass changes no residual where a contact touches nothing that moves."""

    def given(mass):
        return contact_space(np.diag([1.0, 1.0, 0.0, 0.0]) / mass, [-1.0, 0.2, 0.5, 0.0], [0.5, 0.5], 2)

    r = np.array([[0.5, 0.0], [0.1, 0.0]])
    assert residual(given(mass), mass * r) == pytest.approx(residual(given(1.0), r), rel=1e-12)


@pytest.mark.parametrize("free", [[0.3, -0.02, -2.0], [0.0, 0.02, 0.0], [0.3, 0.0, 1e-9]])  # with and without a demand
def test_the_bias_of_a_row_without_a_normal_enters_no_unit(free) -> None:
    dry = hinge(1.0).replace(
        normal=[[0.0, 1.0, 0.3], [0.0, 0.0, 0.0]],
        tangent=[[1.0, 0.0, 0.1], [0.0, 0.0, 1.0]],
        friction_bias=[0.0, 1e-3],
        free_velocity=free,
    )
    for turn in (lambda p: p, lambda p: contact_space(p.W, p.q, p.friction, 2, friction_bias=p.friction_bias)):
        one, other = turn(dry.replace(bias=[0.0, 1.0])), turn(dry.replace(bias=[0.0, 1e9]))
        np.testing.assert_array_equal(one.units, other.units)
        impulse = np.array([[0.0, 0.0], [0.0, 1e-4]])
        assert residual_floor(one, impulse) == residual_floor(other, impulse)


def test_what_the_unit_hides_is_a_share_of_the_speeds() -> None:
    """A block slides with 10 m/s and sinks with less than CANCELLED of it: it cannot be measured, and is not called solved."""
    problem = block(10.0, h=0.1 * CANCELLED * 10.0 / 9.81)
    assert nothing(problem) == pytest.approx(0.1, rel=1e-3)
    finding = verify(problem, Answer(np.zeros((1, 2)), Status.SOLVED), "coulomb", 0.1)
    assert finding.verdict == Verdict.UNJUDGEABLE
    assert "no impulses at all have the residual 0.1" in finding.reason


def grain(mass, fall=1e-3):
    """A grain falls with `fall` onto a slider of 1 kg at 1 m/s, which dry friction, a row of a joint, can stop. Velocities: the
    slider's, the grain's along it and upwards."""
    rows = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0]]
    problem = contacts_of(*rows, [0.0, 0.5], [1.0, 1.0, -fall], mass=np.diag([1.0, mass, mass]), friction_bias=[10.0, 0.0])
    return problem, np.array([[0.0, -1.0], [0.0, 0.0]])  # the slider stops, nothing holds the grain


@pytest.mark.parametrize("mass", [1.0, 1e-6])
def test_what_a_row_hides_is_bounded_by_the_energy_that_it_stops(mass) -> None:
    problem, impulse = grain(mass)
    energy = 1.0 / problem.scale[0]  # c_j^2 / s_j of the row
    assert problem.units[1] == pytest.approx(np.sqrt(problem.scale[1] * energy))
    assert residual(problem, impulse) == pytest.approx(1e-3 / problem.units[1], rel=1e-3)


ROD = ([[0, -1, -1e-3, 0], [0, -1, -1, 1]], [[1, 0, 0, 0]] * 2)  # on a pivot: below it at 1 mm, and a ball above its tip at 1 m
ABOVE = ([[0, 1, 0, 0], [0, -1, 0, 1]], [[1, 0, 0, 0], [-1, 0, 1, 0]])  # a block on the floor, and one on it


@pytest.mark.parametrize(
    ("problem", "impulse", "hidden"),
    [
        (contacts_of(np.eye(2)[::-1], np.eye(2), 0.0, [-1e-3, -10]), [[10, 0], [0, 0]], 1e-4),
        (contact_space(np.eye(4), [-1e-20, 0, -1, 0], 0.5 * np.ones(2), 2), [[0, 0], [1, 0]], 1e-20 / NOISE),
        (contacts_of([[1, 0], [-1, 0], [0, 1]], np.zeros((3, 2)), 0.5, [0, 0]), [[2**30, 0], [2**30, 0], [1, 0]], 2.0**-30),
        (contacts_of([[0, 1], [0, -1]], [[1, 0]] * 2, 0.5, [1, 0], bias=1e-9), [[1, -0.5]] * 2, 1e-9),
        (contacts_of(*ROD, 0.5, [0, 0, 0, -1], joints=np.eye(2, 4)), [[0.01, 0], [0.5 - 0.5e-5, 0]], 1e-8),
        (contacts_of(*ABOVE, 0.5, [10, -1e-3, 1e7, 1], mass=np.diag([1, 1, 1e-10, 1e-10])), np.zeros((2, 2)), 1e-4),
        (contacts_of(*ABOVE, 0.5, [0, -1, 1e9, 2]), [[1, 0], [1e-3, 0]], 1e-3),
    ],
    ids=["impact", "far island", "wedge at rest", "gap", "lever", "grain that parts", "own terms"],
)
def test_what_the_residual_hides(problem, impulse, hidden) -> None:
    """That a block enters a wall; that the slow one of two blocks falls; that a body is set in motion; that walls clamp a block
    which they do not touch; that 0.01 N s across a gap move the tip by 5e-6 m/s; that nothing holds a block, and that one is
    thrown up from afar with 1e-3 m/s."""
    assert residual(problem, np.array(impulse, float)) == pytest.approx(hidden, rel=1e-3)


def verdicts(problem, impulse, model="coulomb"):
    """At 1e-4, 1e-6 and 1e-8, of an answer that claims to be solved."""
    answer = Answer(np.array(impulse), Status.SOLVED)
    return [str(verify(problem, answer, model, tol).verdict) for tol in (1e-4, 1e-6, 1e-8)]


def test_what_is_solved_within_a_tolerance_is_solved_within_larger_ones() -> None:
    """One block falls with 1 m/s, another slides along its floor with a gap of -1e-12 m/s: none has 2e-6."""
    rows = [[0, 1, 0, 0], [0, 0, 0, 1]], [[1, 0, 0, 0], [0, 0, 1, 0]]
    problem = contacts_of(*rows, 0.3, [0.0, -1.0, 1.0, 0.0], bias=[0.0, -1.8e-12])
    assert verdicts(problem, [[1.0, 0.0], [1.8e-12, -5.4e-13]]) == ["solved"] * 3


PAIR = ([[0, 1, 0, 0], [0, 0, 0, 1], [0, -1, 0, 1]], [[1, 0, 0, 0], [0, 0, 1, 0], [-1, 0, 1, 0]])  # two blocks, and between


@pytest.mark.parametrize("contacts", [2, 3])
def test_a_contact_that_is_open_by_far_joins_no_islands(contacts) -> None:
    """Nothing holds the block that slides with 3e4 m/s and sinks with 2e-6 m/s, which its unit can hardly tell from none."""
    normal, tangent = (rows[:contacts] for rows in PAIR)
    problem = contacts_of(normal, tangent, 0.5, [3e4, -2e-6, 0.0, -1.0], bias=[0.0, 0.0, 1e7][:contacts])
    other_falls = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]])[:contacts]
    assert verdicts(problem, other_falls) == ["unjudgeable", "wrong", "wrong"]


@pytest.mark.parametrize("rests", [1e-3, 1e-7])
def test_a_contact_that_is_open_by_far_carries_nothing(rests) -> None:
    """Beside a block that hits the ground with 100 m/s another rests, held by what is 10 m away from it."""
    problem = contacts_of(*PAIR, 0.5, [0.0, -100.0, 0.0, -rests], bias=[0.0, 0.0, 1e4])
    assert verdicts(problem, [[100.0 + rests, 0.0], [0.0, 0.0], [rests, 0.0]]) == ["wrong"] * 3
    far = block(0.0, mass=1.0, h=rests)
    far = contacts_of([[0.0, 1.0]] * 2, [[1.0, 0.0]] * 2, 0.5, far.free_velocity, bias=[0.0, 1.0 / rests])
    assert verdicts(far, [[0.0, 0.0], [9.81 * rests, 0.0]]) == ["wrong"] * 3


@pytest.mark.parametrize(("error", "tight"), [(0.0, "unjudgeable"), (2.0**-30, "unjudgeable"), (2.0**-26, "wrong")])
def test_the_floor_is_that_of_the_law_which_decides(error, tight) -> None:
    """A block squeezed with 1e6 N s slides with 1e4 m/s: the relaxation's unit is 1e3 times that of Coulomb's law."""
    mu, squeeze, fall = 2.0**-10, 2.0**20, 2.0**-7
    problem = contacts_of([[0.0, 1.0], [0.0, -1.0]], [[1.0, 0.0]] * 2, mu, [1e4, -fall])
    r_n = np.array([[squeeze + fall + error], [squeeze]])
    impulse = np.hstack([r_n, -mu * r_n])
    assert verdicts(problem, impulse)[2] == verdicts(problem, impulse, "relaxation")[2] == tight


def test_where_nothing_moves_impulses_may_balance() -> None:
    """A body at rest is wedged between three planes: its equilibrium holds to rounding."""
    angle = np.radians([90.0, 210.0, 330.0])
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    problem = contacts_of(normal, normal[:, ::-1] * [-1.0, 1.0], 0.5, [0.0, 0.0])
    impulse = np.column_stack([np.full(3, 0.1), np.zeros(3)])
    assert verdicts(problem, impulse) == ["solved"] * 3
    assert verdicts(problem, impulse * [[1.0], [1.0], [1.01]]) == ["wrong"] * 3


@pytest.mark.parametrize("demand", [3.1e-8, 2.9e-8])
def test_a_demand_of_thousands_of_roundings_counts(demand) -> None:
    problem = contacts_of([[0.0, 1.0]], [[1.0, 0.0]], 0.0, [3e4, -demand])
    assert problem.units[0] == pytest.approx(CANCELLED * 3e4)
