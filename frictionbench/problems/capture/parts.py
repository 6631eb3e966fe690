"""What the contacts of an engine's step can express, and notes on all other impulses of the step.

With the impulses r of the contacts, lam of the equations F v + b_F = 0, and p_k of everything else (limits, torsion, dry
friction), each as a generalised impulse (nv), a step of an engine is

    M (v+ - v0) = J' r + F' lam + sum_k p_k,

v0 the engine's own velocity of the step without constraints. The problem that is captured has v* = v0 + M^-1 sum_k p_k: what it
cannot express acts as the engine had it act, and each p_k is a note with its share |p_k| over the sum of |J' r|, |F' lam| and
all |p_k|, in the norm of M^-1, in which lengths and angles, masses and inertias add up. b_F = -F v+: the engine's equations are
soft, and its own answer is that of equations that moved so. A constraint J v = a - R f, of softness R, has a note with the
share of f'R f in f'R f + |J' f|^2, 0 for a rigid one.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array, require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.own import EngineStep

FAITHFUL = 1e-9  # of the velocities: what a captured step may miss of the engine's own next velocity
REST = "other forces, the integrator, the solver's tolerance"  # as adhesion, implicit terms that are not symmetric
NOISE = 1e-9  # shares below are rounding
ROUNDING = 1e-13  # of the momentum: impulses below are rounding
ZERO = 1e-14  # of sqrt(M_ii M_jj): entries of M below are rounding of its measurement


class Contacts(NamedTuple):
    """The contacts of a step: rows (3 nc, nv) with the normal first, impulse (nc, 3) in N s, friction (nc,), gap (nc,) in m."""

    rows: Array
    impulse: Array
    friction: Array
    gap: Array


class Step(NamedTuple):
    """mass (nv, nv) that impulses meet; velocity: the next one, free: without constraints (nv,); length: s.

    equations: F (nj, nv). others: p_k by name. softness: shares that are known already, by name.
    """

    mass: Array
    free: Array
    velocity: Array
    length: float
    contacts: Contacts
    equations: Array
    others: Mapping[str, Array]
    softness: Mapping[str, float]


def captured(step: Step) -> EngineStep:
    """The problem of the step with the engine's impulses and notes.

    Errors: InputError where mass is not positive definite, and where the problem's velocity is not the engine's.
    """
    mass = _without_noise(step.mass)
    inverse = np.asarray(np.linalg.inv(mass), dtype=np.float64)
    contacts, F = step.contacts, step.equations
    pushed = contacts.rows.T @ contacts.impulse.ravel()
    whole = mass @ (step.velocity - step.free)
    held = whole - pushed - sum(step.others.values(), np.zeros(len(mass)))
    by_equations, rest = _by_equations(F, inverse, held)
    others = {**step.others, REST: rest}
    sizes = {name: _size(inverse, impulse) for name, impulse in others.items()}
    total = _size(inverse, pushed) + _size(inverse, by_equations) + sum(sizes.values())
    least = max(NOISE * total, ROUNDING * _size(inverse, mass @ (np.abs(step.velocity) + np.abs(step.free))))
    notes = {name: size / total for name, size in sizes.items() if size > least}
    rows = contacts.rows.reshape(-1, 3, len(mass))
    problem = FrictionProblem(
        mass=mass,
        normal=rows[:, 0],
        tangent=rows[:, 1:].reshape(-1, len(mass)),
        friction=contacts.friction,
        free_velocity=step.free + inverse @ sum(others.values()),
        bias=contacts.gap / step.length,
        joints=F,
        joint_bias=-F @ step.velocity,
        dimension=3,
    )
    miss = float(np.abs(problem.velocity(contacts.impulse) - step.velocity).max(initial=0))
    scale = max(1.0, float(np.abs(step.velocity).max(initial=0)), float(np.abs(step.free).max(initial=0)))
    require(miss <= FAITHFUL * scale, "step", f"the captured problem misses the engine's next velocity by {miss:.1e}")
    notes |= {name: share for name, share in step.softness.items() if share > NOISE}
    return EngineStep(problem, contacts.impulse, notes, step.length)


def share_of_softness(mass: Array, rows: Array, force: Array, softness: Array) -> float:
    """f'R f over f'R f + |J' f|^2 in M^-1, for rows J (n, nv), force f (n,) and softness R (n,); 0 without forces."""
    soft = float(force @ (softness * force))
    moved = rows.T @ force
    rigid = float(moved @ np.linalg.solve(mass, moved))
    return soft / (soft + rigid) if soft > 0 else 0.0


def _by_equations(F: Array, inverse: Array, held: Array) -> tuple[Array, Array]:
    """The part of held that equations F can give, and the rest: nearest in the norm of M^-1."""
    if not len(F):
        return np.zeros_like(held), held
    root = np.linalg.cholesky(inverse)  # |p| in M^-1 is |root' p|
    lam = np.linalg.lstsq(root.T @ F.T, root.T @ held, rcond=None)[0]
    return F.T @ lam, held - F.T @ lam


def _size(inverse: Array, impulse: Array) -> float:
    return float(np.sqrt(abs(impulse @ inverse @ impulse)))


def _without_noise(mass: Array) -> Array:
    """The mass, symmetric, with entries that are rounding set to zero, so that separate bodies stay separate."""
    symmetric = (mass + mass.T) / 2
    size: Array = np.sqrt(np.abs(np.diag(symmetric)))
    return np.where(np.abs(symmetric) > ZERO * np.outer(size, size), symmetric, 0.0)
