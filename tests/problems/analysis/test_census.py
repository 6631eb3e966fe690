"""The census agrees with closed-form solutions, with the LCP's own census, and with Lemke's method."""

import warnings

import numpy as np
import pytest

from frictionbench import solvers
from frictionbench.harness.contract.check import in_units, mirrored, permuted
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.analysis.census import Census, census, census_labels
from frictionbench.problems.analysis.mode import mode
from frictionbench.problems.analysis.polyhedra import Polyhedron, Shape, contains, shape
from frictionbench.problems.catalogue import scene
from frictionbench.problems.check import Array
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import residual
from tests.helpers.friction_problems import block, contacts_of, nothing, spatial, with_joints
from tests.helpers.lcp_census import lcp_census


def variant(seed: int) -> FrictionProblem:
    """One body and one to four contacts: plain, partly frictionless, with friction at hand, overlapping, or with ties."""
    random = np.random.default_rng(seed)
    base = random_problem(seed, contacts=1 + seed % 4, bodies=1)
    nc = base.contacts
    names = ("mass", "normal", "tangent", "friction", "free_velocity", "bias")
    given = {name: getattr(base, name) for name in names}
    match seed % 5:
        case 1:
            given |= {"friction": np.where(random.random(nc) < 0.5, 0, base.friction)}
        case 2:
            given |= {"friction_bias": np.where(random.random(nc) < 0.7, random.random(nc), 0)}
            given |= {"friction": np.where(random.random(nc) < 0.3, 0, base.friction)}
        case 3:
            given |= {"bias": -random.random(nc)}
        case 4:
            nv = len(base.free_velocity)
            given |= {"mass": np.eye(nv), "friction": np.ones(nc), "bias": np.zeros(nc)}
            given |= {name: np.round(given[name].toarray()) for name in ("normal", "tangent")}
            given |= {"free_velocity": np.round(base.free_velocity)}
    return FrictionProblem(**given)


def unit(problem: FrictionProblem) -> Array:
    """What makes impulses (2 nc,) pure numbers."""
    return np.repeat(problem.scale, 2) / (np.abs(problem.q).max() or 1.0)


def test_no_contact_has_one_empty_solution() -> None:
    found = census(nothing())
    assert found.shape is Shape.ONE
    assert found.count == 1
    assert found.pieces[0].vertices.shape == (1, 0)


def test_friction_bias_on_opening_contact() -> None:
    """A slow particle leaves the ground and yet is held along it by the friction bias; a fast one is slowed by all of it."""
    for speed, left, letter in ((0.1, 0.0, "S"), (1.0, 0.75, "R"), (-1.0, -0.75, "L")):
        problem = contacts_of([[0, 1]], [[1, 0]], 0.5, [speed, 1.0], mass=2 * np.eye(2), friction_bias=[0.5])
        found = census(problem)
        assert [piece.mode for piece in found.pieces] == [letter]
        assert found.pieces[0].vertices == pytest.approx(np.array([[0, 2 * (left - speed)]]))
        assert found.velocities[0].vertices == pytest.approx(np.array([[1, left]]))


@pytest.mark.parametrize("blocks", [1, 2, 3])
def test_a_stack_at_rest_is_hyperstatic(blocks: int) -> None:
    """Each interface has two contacts, four impulses for three freedoms: one free parameter a block, and one velocity."""
    found = census(scene("stack", blocks=blocks, push=0.0).problem())
    assert found.shape is Shape.CONVEX
    assert found.count is None
    assert found.velocity_count == 1
    assert [(piece.mode, piece.dimension, len(piece.vertices)) for piece in found.pieces] == [
        ("ss" * blocks, blocks, 2**blocks)
    ]
    assert found.velocities[0].vertices == pytest.approx(np.zeros((1, 4 * blocks)), abs=1e-12)


@pytest.mark.parametrize("seed", range(40))
def test_agreement_with_lcp_census(seed: int) -> None:
    """The LCP's own census walks over 2^(4 nc) bases; its vertices are in the pieces, and those of the pieces among its."""
    problem = variant(seed)
    nc = problem.contacts
    found = census(problem)
    for piece in found.pieces:
        for vertex in piece.vertices:
            assert residual(problem, vertex.reshape(nc, 2)) <= 1e-10
            for ray in piece.rays:
                assert residual(problem, (vertex + ray).reshape(nc, 2)) <= 1e-10
    pieces = [Polyhedron(piece.vertices * unit(problem), piece.rays * unit(problem), piece.mode) for piece in found.pieces]
    if nc <= 2:
        lcp = problem.lcp()
        impulses = [lcp.impulse(z).ravel() * unit(problem) for piece in lcp_census(lcp).pieces for z in piece.vertices]
        assert all(any(contains(piece, r) for piece in pieces) for r in impulses)
        assert all(any(contains(Polyhedron(r[None], r[:0, None]), x) for r in impulses) for p in pieces for x in p.vertices)
    answer = solvers.solve(problem, "lemke", tol=1e-10)
    if answer.status is solvers.Status.SOLVED:
        assert any(contains(piece, answer.impulse.ravel() * unit(problem)) for piece in pieces)
    else:
        assert (problem.bias < 0).any()


def test_variants_cover_every_shape() -> None:
    assert {census(variant(seed)).shape for seed in range(80)} == set(Shape)


@pytest.mark.parametrize("seed", range(0, 30, 3))
def test_census_invariance(seed: int) -> None:
    problem = variant(seed)
    moved = in_units(mirrored(permuted(problem, np.arange(problem.contacts)[::-1])), 1e3, 1e-3)
    a, b = census(problem), census(moved)
    assert (a.shape, a.count, a.velocity_count) == (b.shape, b.count, b.velocity_count)
    swap = str.maketrans("lrLR", "rlRL")
    assert sorted(p.dimension for p in a.pieces) == sorted(p.dimension for p in b.pieces)
    if a.shape is Shape.ONE:
        assert a.pieces[0].mode == b.pieces[0].mode[::-1].translate(swap)


def test_a_block_on_rails() -> None:
    """A joint takes up any normal impulse, so friction may brake it by any amount: an arc and a ray."""
    found = census(with_joints(block(), [[0.0, 1.0]]))
    assert found.shape is Shape.NOT_CONVEX
    assert {(p.mode, p.dimension, len(p.rays)) for p in found.pieces} == {("r", 1, 0), ("s", 1, 1)}
    (sliding,) = (p for p in found.pieces if p.mode == "r")
    assert sorted(sliding.vertices.tolist()) == pytest.approx(np.array([[0, 0], [4, -2]]), abs=1e-12)
    assert [velocities.dimension for velocities in found.velocities] == [1]
    assert found.velocity_count is None


def test_round_off_vertices_are_rejected(monkeypatch) -> None:
    """Seven contacts on two bodies of very unlike mass: with the finest tie, vertices at 1e13 N s come of round-off alone."""
    problem = random_problem(1007, contacts=7, bodies=2, mass_ratio=10**5.3832828)
    found = census(problem)
    assert (found.shape, found.velocity_count) == (Shape.CONVEX, 1)
    assert max(residual(problem, r.reshape(7, 2)) for piece in found.pieces for r in piece.vertices) <= 1e-10
    monkeypatch.setattr("frictionbench.problems.analysis.census.TIES", (1e-12,))
    monkeypatch.setattr("frictionbench.problems.analysis.census.census", overheard)
    with pytest.warns(UserWarning, match="ill-conditioned"):
        assert set(census_labels(problem).values()) == {None}


def overheard(problem: FrictionProblem) -> Census:
    """A census whose error is told on its way to whoever takes it."""
    try:
        return census(problem)
    except ArithmeticError as error:
        warnings.warn(str(error), stacklevel=2)
        raise


def test_unsupported_problems_are_refused() -> None:
    large = random_problem(0, contacts=9, friction=0.5)
    for field, problem in {"contacts": large, "dimension": spatial(0)}.items():
        with pytest.raises(InputError, match=f"{field}: "):
            census(problem)
    assert set(census_labels(large).values()) == {None}


def test_modes_of_answers() -> None:
    for speed, expected in {0.0: "s", 1.0: "r", -1.0: "l"}.items():
        problem = block(speed=speed)
        assert mode(problem, solvers.solve(problem, "lemke").impulse) == expected
    assert mode(problem, np.zeros((1, 2))) == "o"
    assert mode(nothing(), np.zeros((0, 2))) == ""


def test_shapes_of_unions() -> None:
    def segment(a: list[float], b: list[float]) -> Polyhedron:
        return Polyhedron(np.array([a, b]), np.zeros((0, 2)))

    def look(*pieces: Polyhedron) -> Shape:
        return shape(list(pieces), lambda x: any(contains(piece, x) for piece in pieces))

    points = [Polyhedron(np.array([[x, 0.0]]), np.zeros((0, 2))) for x in (0.0, 1.0, 2.0)]
    quadrant = Polyhedron(np.zeros((1, 2)), np.eye(2))
    assert look() is Shape.NONE
    assert look(points[0]) is Shape.ONE
    assert look(*points) is Shape.ISOLATED
    assert look(segment([0, 0], [1, 0]), segment([1, 0], [2, 0])) is Shape.CONVEX
    assert look(segment([0, 0], [1, 0]), segment([1, 0], [2, 1])) is Shape.NOT_CONVEX
    assert look(quadrant) is Shape.CONVEX
    assert look(quadrant, segment([0, 0], [-1, 0])) is Shape.NOT_CONVEX
    assert contains(quadrant, np.array([3.0, 1e-9]))
    assert not contains(quadrant, np.array([3.0, -1e-3]))
