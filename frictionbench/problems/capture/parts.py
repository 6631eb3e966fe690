"""What the rows of a friction problem can express of an engine's step, and notes on all other impulses of the step.

With the impulses r of contacts, limits and dry friction, lam of the equations F v + b_F = 0, and p_k of everything else
(torsion, rolling), each as a generalised impulse (nv), a step of an engine is

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
    """The contacts of a step, then its limits and its dry friction in the conventions of FrictionProblem.

    rows (3 nc, nv) with the normal first, impulse (nc, 3) in N s, friction (nc,), gap (nc,) in m, loss (nc,) in N s: the
    friction bias.
    """

    rows: Array
    impulse: Array
    friction: Array
    gap: Array
    loss: Array

    def and_limits(self, rows: Array, impulse: Array, gap: Array) -> "Contacts":
        """With limits besides: rows (n, nv), impulse (n,), gap (n,)."""
        return self._joined(0, rows, impulse, gap, np.zeros(len(rows)))

    def and_dry_friction(self, rows: Array, impulse: Array, loss: Array, step: float) -> "Contacts":
        """With dry friction besides: rows (n, nv), impulse (n,), loss (n,) in N s; step in s, so that the bias is 1."""
        return self._joined(1, rows, impulse, np.full(len(rows), step), loss)

    def _joined(self, place: int, rows: Array, impulse: Array, gap: Array, loss: Array) -> "Contacts":
        three, used = np.zeros((len(rows), 3, rows.shape[1])), np.zeros((len(rows), 3))
        three[:, place], used[:, place] = rows, impulse
        added = three.reshape(-1, rows.shape[1]), used, np.zeros(len(rows)), gap, loss
        return Contacts(*(np.concatenate(pair) for pair in zip(self, added, strict=True)))


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

    Errors: InputError where the step is not finite or mass not positive definite, and where the problem's velocity is not the
    engine's.
    """
    require_finite(step.mass, step.free, step.velocity)
    mass = without_noise(step.mass)
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
    free = step.free + inverse @ sum(others.values())
    problem = posed(mass, free, contacts, contacts.gap / step.length, F, -F @ step.velocity)
    miss = float(np.abs(problem.velocity(contacts.impulse) - step.velocity).max(initial=0))
    scale = max(1.0, float(np.abs(step.velocity).max(initial=0)), float(np.abs(step.free).max(initial=0)))
    require(miss <= FAITHFUL * scale, "step", f"the captured problem misses the engine's next velocity by {miss:.1e}")
    notes |= {name: share for name, share in step.softness.items() if share > NOISE}
    return EngineStep(problem, contacts.impulse, notes, step.length)


def posed(mass: Array, free: Array, contacts: Contacts, bias: Array, F: Array, joint_bias: Array) -> FrictionProblem:
    """The problem of these rows."""
    rows = contacts.rows.reshape(-1, 3, len(mass))
    return FrictionProblem(
        mass=mass,
        normal=rows[:, 0],
        tangent=rows[:, 1:].reshape(-1, len(mass)),
        friction=contacts.friction,
        free_velocity=free,
        bias=bias,
        friction_bias=contacts.loss,
        joints=F,
        joint_bias=joint_bias,
        dimension=3,
    )


def require_finite(*arrays: Array) -> None:
    """Errors: InputError where one of a step's arrays holds an infinity or a NaN."""
    finite = all(np.isfinite(array).all() for array in arrays)
    require(finite, "data", "masses, forces or velocities are not finite: the simulation has diverged")


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


def without_noise(mass: Array) -> Array:
    """The mass, symmetric, with entries that are rounding set to zero, so that separate bodies stay separate."""
    symmetric = (mass + mass.T) / 2
    size: Array = np.sqrt(np.abs(np.diag(symmetric)))
    return np.where(np.abs(symmetric) > ZERO * np.outer(size, size), symmetric, 0.0)
