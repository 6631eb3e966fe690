"""The convex relaxation in pure numbers, so that an outside library's tolerances have one meaning.

The program  min ½ x'Px + q'x,  h - G x in a cone,  A x = b  of problems.forms.relaxation becomes, with x = theta D x^,

    P^ = D P D,    q^ = D q / theta,    G^ = E G D,    h^ = E h / theta,    A^ = E_A A D,    b^ = E_A b / theta,

D = 1/sqrt(M_ii) on velocities and E_i = 1/sqrt(s_i) on contact i's rows: a unit diagonal in the objective, rows of about unit
length, and theta = max_i |q_i| / sqrt(s_i) makes the free contact velocities at most 1. Then z = theta E z^. An error eps in a
scaled row is eps theta sqrt(s_i) of contact velocity, so

    eps = tol max_i |q_i| / (theta max_i sqrt(s_i))  <=  tol

keeps every contact's velocity error below tol max|q_i|, the measure of problems.residual.

The duality gap is the sum of the products r_i'u_i. Where impulse and velocity vanish together (a contact about to slide or to
part), and all along a round cone, a gap of eps leaves an error of sqrt(eps): so the gap is asked to fall to eps^2. It is a
difference of objectives of size 1, and stops falling near 1e-15; flat cones need no less than 1e-13.
"""

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from scipy import sparse

from problems import FrictionProblem
from problems.check import Array
from problems.forms.relaxation import QP, ConeProgram

Program = TypeVar("Program", QP, ConeProgram)


@dataclass(frozen=True, eq=False)
class ScaledProgram(Generic[Program]):
    """The scaled P, q, G, h, A, b; `share`, eps over tol; and what turns scaled multipliers into impulses."""

    program: Program
    P: sparse.csc_matrix
    q: Array
    G: sparse.csc_matrix
    h: Array
    A: sparse.csc_matrix
    b: Array
    unit: Array
    share: float

    def impulse(self, z: Array) -> Array:
        """The contact impulses (nc, d) of scaled multipliers of G."""
        return self.program.impulse(self.unit * z)


def gap_tolerance(eps: float, round_cones: bool) -> float:
    """The duality gap at which errors fall to eps, as far as arithmetic lets it."""
    return max(eps**2, 1e-15 if round_cones else 1e-13)


def scaled_program(problem: FrictionProblem, program: Program) -> ScaledProgram[Program]:
    """Scale a problem's relaxation, as a QP or as a cone program."""
    nc, d = problem.contacts, problem.dimension
    s, wide = problem.scale, problem.friction_bias > 0
    blocks = np.concatenate([s, s[wide]])
    rows = np.repeat(np.sqrt(blocks), program.G.shape[0] // max(len(blocks), 1))
    D = np.concatenate([1 / np.sqrt(problem.mass.diagonal()), np.sqrt(s[wide])])
    size = np.linalg.norm(problem.q.reshape(nc, d), axis=1)
    theta = float((size / np.sqrt(s)).max(initial=0.0)) or 1.0
    length = np.sqrt((program.A * D).power(2).sum(axis=1))
    joint = 1 / np.where(length > 0, length, 1.0)
    share = float(size.max(initial=0.0) / (theta * np.sqrt(s).max(initial=0.0))) if size.any() else 1.0
    return ScaledProgram(
        program,
        sparse.csc_matrix(program.P * D * D[:, None]),
        D * program.q / theta,
        sparse.csc_matrix(program.G * D / rows[:, None]),
        program.h / rows / theta,
        sparse.csc_matrix(program.A * D * joint[:, None]),
        program.b * joint / theta,
        theta / rows,
        share,
    )
