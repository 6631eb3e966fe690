"""The mode of each contact in an answer, and the distance of an answer from the nearest change of mode."""

import numpy as np

from frictionbench.problems.check import Array, require
from frictionbench.problems.friction import FrictionProblem

ZERO = 1e-6  # relative to a contact's unit: smaller velocities, and impulses that change velocities by less, count as zero


def mode(problem: FrictionProblem, impulse: Array) -> str:
    """The mode of each planar contact in an answer (nc, 2): "o"pen, "s"ticking, sliding "l"eft or "r"ight."""
    require(problem.dimension == 2, "dimension", "modes are for planar problems, dimension 2")
    least = ZERO * problem.units
    opened = problem.scale * np.abs(impulse).max(axis=1, initial=0.0) <= least
    along = problem.contact_velocity(impulse)[:, 1]
    slip = np.where(np.abs(along) > least, np.sign(along), 0).astype(int)
    return "".join(np.where(opened, "o", np.array(["s", "r", "l"])[slip]))


def distance_to_next_mode(problem: FrictionProblem, impulse: Array) -> float:
    """The distance of a solution (nc, 2) from the nearest change of mode, as a velocity in the contact's unit; 0 on a tie.

    An open contact changes its mode when u_n reaches 0, a closed one when s r_n does, a sticking one when s |r_t| reaches its
    limit, and a sliding one when u_t reaches 0. Infinity if nothing moves, as without contacts.
    """
    require(problem.dimension == 2, "dimension", "modes are for planar problems, dimension 2")
    if not problem.velocity_scale:
        return np.inf
    u, felt = problem.contact_velocity(impulse), problem.scale[:, None] * impulse
    limit = problem.friction * felt[:, 0] + problem.scale * problem.friction_bias - np.abs(felt[:, 1])
    slides = np.abs(u[:, 1]) > np.abs(limit)
    closed = np.minimum(felt[:, 0], np.where(slides, np.abs(u[:, 1]), limit))
    return float((np.maximum(np.where(felt[:, 0] > u[:, 0], closed, u[:, 0]), 0.0) / problem.units).min())
