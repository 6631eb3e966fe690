"""Scenes by name, their parameters, and the problems they generate."""

import pickle

import numpy as np
import pytest

from frictionbench import problem
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import scene, scenes
from frictionbench.problems.planar.bodies import Geometry, hollow, rigid_box
from frictionbench.problems.planar.joints import Hinge
from frictionbench.problems.scene import Scene
from frictionbench.solvers import solve


@pytest.mark.parametrize("name", scenes())
def test_scene_descriptions(name: str) -> None:
    info = scenes()[name]
    assert info.summary.endswith(".")
    made = scene(name)
    assert "friction" in info.parameters or not made.obstacles
    assert made.name == name
    assert made.dimension == info.dimension
    assert made.parameters == info.parameters
    assert all(isinstance(value, (int, float)) for value in made.parameters.values())
    assert made.steps == round(made.duration / made.step)


@pytest.mark.parametrize("name", scenes())
def test_no_initial_overlap(name: str) -> None:
    made = scene(name)
    assert made.contacts(made.q0, 0.0).gap.min(initial=0.0) >= -made.touch


@pytest.mark.parametrize("name", scenes())
def test_scenes_are_picklable(name: str) -> None:
    made = scene(name)
    assert pickle.loads(pickle.dumps(made)).problem().hash == made.problem().hash


def test_unknown_names_and_values() -> None:
    with pytest.raises(InputError, match=r"^scene: unknown scene 'heap'; `frictionbench list scenes` names all"):
        scene("heap")
    with pytest.raises(InputError, match=r"^brick: the scene stack has no such parameter; it has blocks, "):
        scene("stack", brick=3)
    for name, parameter, value in (
        ("stack", "blocks", 0),
        ("stack", "friction", -0.1),
        ("long_bar", "restitution", 1.5),
        ("wedge", "angle", 0.0),
        ("jam", "overlap", -0.6),
        ("woodpecker", "restitution", 2.0),
        ("packed_spheres", "fraction", 0.9),
        ("box_wall", "points", 6),
        ("random_graph", "bodies", 3),
    ):
        with pytest.raises(InputError, match=rf"^{parameter}: "):
            problem(name, **{parameter: value})


def test_fields_of_a_scene_are_checked() -> None:
    with pytest.raises(InputError, match=r"^q0: expected length 3"):
        Scene(bodies=(rigid_box(1, 1),), q0=np.zeros(4), friction=0.5)
    with pytest.raises(InputError, match=r"^v0: "):
        Scene(bodies=(rigid_box(1, 1),), q0=np.zeros(3), v0=np.array([np.inf, 0, 0]), friction=0.5)
    with pytest.raises(InputError, match=r"^mass: "):
        rigid_box(1, 1, density=-1)
    with pytest.raises(InputError, match=r"^hinges: refer to bodies that do not exist: \[\(0, 1\)\]"):
        Scene(bodies=(rigid_box(1, 1),), hinges=(Hinge((0, 1), np.zeros((2, 2))),), q0=np.zeros(3), friction=0.5)
    with pytest.raises(InputError, match=r"^bodies: "):
        Hinge((0, 0), np.zeros((2, 2)))
    with pytest.raises(InputError, match=r"^step: 1e-160 s is too short: 1.0 s would take more than 1e\+15 steps"):
        scene("incline", step=1e-160)
    assert scene("incline", step=10.0).steps == 1  # a motion of no steps would count as solved
    with pytest.raises(InputError, match=r"^obstacles: a hollow is only possible where all bodies are discs"):
        Geometry((rigid_box(1, 1),), (hollow(3.0),))


def test_bodies_on_a_hinge_do_not_collide() -> None:
    boxes, q = (rigid_box(1, 1),) * 3, np.array([[0, 0, 0], [0.9, 0, 0], [1.8, 0, 0]])
    hinge = Hinge((1, 0), np.array([[-0.45, 0.0], [0.45, 0.0]]))
    loose = Scene(bodies=boxes, q0=q, friction=0.5)
    held = Scene(bodies=boxes, q0=q, friction=0.5, hinges=(hinge,))
    assert [set(map(tuple, s.contacts(s.q0).bodies.tolist())) for s in (loose, held)] == [{(0, 1), (1, 2)}, {(1, 2)}]


@pytest.mark.parametrize("name", ["pendulum", "slider_crank"])
def test_hinge_jacobian(name: str) -> None:
    made = scene(name)
    theta, F = made.joints(made.q0)
    assert theta == pytest.approx(np.zeros(len(theta)), abs=1e-15)
    assert F @ made.v0 == pytest.approx(np.zeros(len(theta)), abs=1e-12)
    q = made.q0 + np.random.default_rng(0).standard_normal(len(made.q0))
    eps = 1e-6
    for k, e in enumerate(np.eye(len(q))):
        slope = (made.joints(q + eps * e)[0] - made.joints(q - eps * e)[0]) / (2 * eps)
        assert made.joints(q)[1].toarray()[:, k] == pytest.approx(slope, abs=1e-8)


def test_contact_counts() -> None:
    for blocks in (1, 2, 7):
        assert scene("stack", blocks=blocks).problem().contacts == 2 * blocks
    for rows in (1, 2, 5):
        assert scene("pyramid", rows=rows).problem().contacts == 2 * rows + 2 * rows * (rows - 1)
    for rows, columns in ((1, 3), (2, 2), (4, 5)):
        side = sum(columns - row % 2 - 1 for row in range(rows))
        above = sum(2 * (columns - 1) for _ in range(1, rows))
        assert scene("wall", rows=rows, columns=columns).problem().contacts == 2 * (columns + side + above)
    assert scene("painleve_rod").problem().contacts == 1
    for name, contacts in (("long_bar", 0), ("jam", 2), ("wedge", 2), ("two_corner_block", 2), ("incline", 2), ("bowl", 1)):
        assert scene(name).problem().contacts == contacts
    for name, contacts in (("redundant_table", 4), ("rocking_block", 1), ("bouncing_ball", 0), ("slider_crank", 0)):
        assert scene(name).problem().contacts == contacts


def test_large_stack_is_sparse() -> None:
    problem = scene("stack", blocks=1000).problem()
    assert problem.contacts == 2000
    assert problem.jacobian.nnz <= 6 * 4000
    assert problem.W.nnz <= 12 * 4000  # a contact meets those of its own and the two neighbouring interfaces


def test_first_problem_of_a_resting_box() -> None:
    made = scene("stack", blocks=1, friction=0.3, push=0.0)
    problem = made.problem()
    assert problem.q == pytest.approx([-0.0981, 0, -0.0981, 0])
    assert problem.friction.tolist() == [0.3, 0.3]
    assert problem.normal.toarray() == pytest.approx(np.array([[0, 1, 0.5], [0, 1, -0.5]]))
    assert problem.tangent.toarray() == pytest.approx(np.array([[1, 0, 0.5], [1, 0, 0.5]]))


@pytest.mark.parametrize(("friction", "holds"), [(0.3, True), (0.12, False)])
def test_house_of_cards_stands_by_friction(friction: float, holds: bool) -> None:
    problem = scene("house_of_cards", storeys=3, friction=friction).problem()
    after = problem.velocity(solve(problem, "lemke", tol=1e-10).impulse)
    assert bool(np.abs(after).max() < 1e-8) is holds


@pytest.mark.parametrize(("name", "size"), [("stack", {"blocks": 2}), ("pyramid", {}), ("wall", {"rows": 2})])
def test_piles_slide_down_slopes_steeper_than_their_friction(name: str, size: dict[str, int]) -> None:
    """Such as do not tip over."""
    for slope, rests in ((0.3, True), (0.4, False)):
        problem = scene(name, **size, friction=np.tan(0.35), push=0.0, slope=slope).problem()
        after = problem.velocity(solve(problem, "lemke", tol=1e-10).impulse)
        assert bool(np.abs(after).max() < 1e-8) is rests


def test_friction_of_two_bodies_is_the_geometric_mean() -> None:
    made = scene("stack", blocks=5, friction=0.5, smooth=0.04, mass_unit=2.0)
    at = made.contacts(made.q0)
    mu = {frozenset(pair): value for pair, value in zip(at.bodies.tolist(), made.problem().friction.tolist(), strict=True)}
    interfaces = [mu[frozenset(pair)] for pair in ((0, -1), (1, 0), (2, 1), (3, 2), (4, 3))]
    assert interfaces == pytest.approx([0.5, 0.5, 0.1, 0.02, 0.1])
    assert scene("stack", smooth=0.0).friction == 0.5
    with pytest.raises(InputError, match=r"^smooth: "):
        scene("stack", smooth=-1.0)


def test_ripple_and_chain_hold_their_hinges() -> None:
    made = scene("chain", links=6, ripple=2.0, fall=0.5, mass_ratio=10.0)
    theta, F = made.joints(made.q0)
    assert theta == pytest.approx(np.zeros(10), abs=1e-15)
    assert F @ made.v0 == pytest.approx(np.zeros(10), abs=1e-15)
    assert made.problem().contacts == 12
