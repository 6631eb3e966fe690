"""The mode of each contact in an answer, and the distance of an answer from the nearest change of mode."""

import numpy as np

from frictionbench.problems.check import Array, require
from frictionbench.problems.friction import FrictionProblem


def mode(problem: FrictionProblem, impulse: Array, tol: float = 1e-6) -> str:
    """The mode of each planar contact in an answer (nc, 2): "o"pen, "s"ticking, sliding "l"eft or "r"ight.

    An impulse below tol |q|/s and a velocity below tol |q| count as zero, q the largest free contact velocity.
    """
    require(problem.dimension == 2, "dimension", "modes are for planar problems, dimension 2")
    u = problem.contact_velocity(impulse)
    free = np.abs(problem.q).max(initial=0.0)
    opened = problem.scale * np.abs(impulse).max(axis=1, initial=0.0) <= tol * free
    slip = np.where(np.abs(u[:, 1]) <= tol * free, 0, np.sign(u[:, 1])).astype(int)
    return "".join(np.where(opened, "o", np.array(["s", "r", "l"])[slip]))


def distance_to_next_mode(problem: FrictionProblem, impulse: Array) -> float:
    """The distance of a solution (nc, 2) from the nearest change of mode, as a velocity over the largest free one; 0 on a tie.

    An open contact changes where u_n reaches 0, a closed one where s r_n does; a sticking one where s |r_t| reaches its limit,
    a sliding one where u_t reaches 0. Infinity without contacts.
    """
    require(problem.dimension == 2, "dimension", "modes are for planar problems, dimension 2")
    free = np.abs(problem.q).max(initial=0.0)
    if not free:
        return np.inf
    u, felt = problem.contact_velocity(impulse), problem.scale[:, None] * impulse
    limit = problem.friction * felt[:, 0] + problem.scale * problem.friction_bias - np.abs(felt[:, 1])
    slides = np.abs(u[:, 1]) > np.abs(limit)
    closed = np.minimum(felt[:, 0], np.where(slides, np.abs(u[:, 1]), limit))
    return float(np.maximum(np.where(felt[:, 0] > u[:, 0], closed, u[:, 0]), 0.0).min() / free)
