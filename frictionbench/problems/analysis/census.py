"""The census of a small planar friction problem: the complete set of its solutions.

Coulomb's law is piecewise linear. In a mode, which states for every contact whether it is open, sticks or slides
to the left or right, the solutions are a polyhedron:

    open    r_n = 0, u_n >= 0                        stick   u_t = 0, |r_t| <= mu r_n + b_f
    closed  r_n >= 0, u_n = 0                        right   u_t >= 0, r_t = -(mu r_n + b_f)      left the mirror image

The census enumerates the modes contact by contact. It represents the polyhedron of the choices made so far by its vertices and
rays (problems.analysis.polyhedra), and prunes a branch if it is empty. Unlike an enumeration of the LCP's bases, it finds
segments, faces and rays of solutions as well as points: for example, hyperstatic impulses, and the nonconvex set of solutions
of the scene jam.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import prod

import numpy as np

from frictionbench.problems.analysis.polyhedra import (
    SAME_POINT,
    Cone,
    Polyhedron,
    Shape,
    cut,
    distinct,
    is_face,
    is_subset,
    maximal,
    polyhedron,
    samples,
    shape,
    simplicial,
)
from frictionbench.problems.check import Array, InputError, require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.residual import residual

MODES = 4**8  # the largest number of modes that is enumerated, in some seconds
TIES = (1e-12, 1e-11, 1e-10, 1e-9)  # relative to the largest free velocity: smaller ones count as zero; the first that suffices
WRONG_RESIDUAL = 1e-7  # a point with a larger residual is not a solution but an effect of rounding

Cut = tuple[Array, bool]  # row'(x, 1) >= 0, or = 0 if the flag is set
Choice = tuple[str, tuple[Cut, ...]]  # one mode of a contact: its letter, and the linear conditions under which it holds


@dataclass(frozen=True, eq=False)
class Census:
    """All solutions of a problem: the impulses x (nc*d,), N s, and their contact velocities y (nc*d,), m/s.

    pieces: maximal polyhedra of solutions, each with its mode, a letter per contact ("o"pen, "s"tick, "l"eft, "r"ight,
    "c"losed without friction, and in capitals open contacts with a friction bias).
    velocities: the maximal images of the pieces in y; different impulses may have the same velocity.
    shape: whether there are none, one, a convex set, isolated points, or another nonconvex set.
    """

    pieces: tuple[Polyhedron, ...]
    velocities: tuple[Polyhedron, ...]
    shape: Shape

    @property
    def count(self) -> int | None:
        """The number of solutions, None if it is infinite."""
        return _count(self.pieces)

    @property
    def velocity_count(self) -> int | None:
        """The number of different velocities of the solutions, None if it is infinite."""
        return _count(self.velocities)


def census(problem: FrictionProblem) -> Census:
    """All solutions of a planar friction problem.

    Impulses are in units of |q|/s, where s is the mean diagonal of a contact's block of W, so that tolerances are relative:
    impulses up to 1e-7 apart are equal, velocities below 1e-12 times the largest free one are zero, and impulses beyond
    1e12 |q|/s are infinite. If a generator found in this way is not a solution, because of rounding with an ill-conditioned W,
    the latter two tolerances are relaxed by powers of ten, up to 1e-9.
    A few contacts take milliseconds; eight take up to some seconds if most modes are possible.
    Errors: InputError for spatial problems and for more than 4^8 modes: 8 contacts with friction, fewer with friction_bias.
    ArithmeticError if no such tolerance suffices.
    """
    require(problem.dimension == 2, "dimension", "a census is for planar problems, dimension 2")
    nc = problem.contacts
    root = np.sqrt(np.repeat(problem.scale, 2))
    free = np.abs(problem.q / root).max(initial=0.0) or 1.0
    eye = np.eye(2 * nc + 1)
    velocity = np.column_stack([problem.W.toarray() / root / root[:, None], problem.q / root / free])
    facets: list[Array] = [eye[-1]]
    cuts: list[Cut] = []
    choices: list[list[Choice]] = []
    for i in range(nc):
        mu, b = problem.friction[i], problem.friction_bias[i] * root[2 * i] / free
        r_n, r_t, u_n, u_t = eye[2 * i], eye[2 * i + 1], velocity[2 * i], velocity[2 * i + 1]
        limit = mu * r_n + b * eye[-1]
        wide = limit if mu else r_n + limit  # without friction the cone is a half-line: start with a wider one
        facets += [wide + r_t, wide - r_t]
        cuts += [(r_n, False), (limit + r_t, False), (limit - r_t, False)]
        # The cuts on the impulse come first: they only select a face, which leaves fewer generators for the next cuts.
        slips: list[tuple[str, tuple[Cut, ...], tuple[Cut, ...]]] = [
            ("s", (), ((u_t, True),)),
            ("l", ((limit - r_t, True),), ((-u_t, False),)),
            ("r", ((limit + r_t, True),), ((u_t, False),)),
        ]
        closed: list[Choice] = [(name, (*r, (u_n, True), *u)) for name, r, u in (slips if mu or b else [("c", (), ())])]
        opened: list[Choice] = [(name.upper(), (*r, (r_n, True), (u_n, False), *u)) for name, r, u in slips if b]
        choices.append(closed + (opened or [("o", ((r_n, True), (u_n, False)))]))

    def is_solution(r: Array) -> bool:
        return residual(problem, r.reshape(nc, 2)) <= WRONG_RESIDUAL

    return enumerate_solutions(np.array(facets), cuts, choices, velocity, free / root, free * root, is_solution)


def census_labels(problem: FrictionProblem) -> dict[str, str | int | None]:
    """The census in plain values, for a table; all None if a census is not possible.

    solutions: the Shape of the set of impulses: "none", "one", "convex", "isolated" or "not convex".
    outcomes: the number of velocities, None also if it is infinite.
    """
    try:
        census_result = census(problem)
    except (InputError, ArithmeticError):
        return {"solutions": None, "outcomes": None}
    return {"solutions": census_result.shape.value, "outcomes": census_result.velocity_count}


def _walk(cone: Cone, choices: list[list[Choice]], mode: str = "") -> Iterator[Polyhedron]:
    """The polyhedra of solutions in all modes that start with the choices made so far."""
    here = polyhedron(cone, mode)
    if here is None:
        return
    if len(mode) == len(choices):
        yield here
        return
    for name, cuts in choices[len(mode)]:
        rest = cone
        for row, equality in cuts:
            rest = cut(rest, row, equality)
        yield from _walk(rest, choices, mode + name)


def enumerate_solutions(
    facets: Array,
    cuts: list[Cut],
    choices: list[list[Choice]],
    y: Array,
    x_unit: Array,
    y_unit: Array,
    is_solution: Callable[[Array], bool],
) -> Census:
    """The census of the points x with facets (x, 1) >= 0 and the cuts. y (x, 1): the velocities. x_unit, y_unit: the units.

    Errors: InputError for more than MODES modes; ArithmeticError if no tolerance of TIES suffices.
    """
    modes = prod(len(several) for several in choices)
    require(modes <= MODES, "contacts", f"a census enumerates at most {MODES} modes; this problem has {modes}")
    for tie in TIES:
        cone = simplicial(facets, tie)
        for row, equality in cuts:
            cone = cut(cone, row, equality)
        pieces = maximal(_walk(cone, choices), is_face)
        if all(is_solution(x * x_unit) for piece in pieces for x in samples(piece)):
            break
    else:
        raise ArithmeticError("census: the problem is too ill-conditioned to separate its solutions")
    images = maximal((_image(piece, y) for piece in pieces), is_subset)
    return Census(
        tuple(_scaled(piece, x_unit) for piece in pieces),
        tuple(_scaled(image, y_unit) for image in images),
        shape(pieces, lambda x: is_solution(x * x_unit)),
    )


def _image(piece: Polyhedron, y: Array) -> Polyhedron:
    """The image of the piece under x -> y @ (x, 1); different impulses may have the same velocity."""
    vertices, rays = piece.vertices @ y[:, :-1].T + y[:, -1], piece.rays @ y[:, :-1].T
    return Polyhedron(distinct(vertices), rays[np.abs(rays).max(axis=1, initial=0.0) > SAME_POINT], piece.mode)


def _scaled(piece: Polyhedron, unit: Array) -> Polyhedron:
    return Polyhedron(piece.vertices * unit, piece.rays * unit, piece.mode)


def _count(pieces: tuple[Polyhedron, ...]) -> int | None:
    return None if any(len(piece.vertices) + len(piece.rays) > 1 for piece in pieces) else len(pieces)
