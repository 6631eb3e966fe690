"""The capture of an engine's step as a friction problem, with notes on all impulses that the problem cannot express.

Let r be the impulses of contacts, limits and dry friction, lam those of the equations F v + b_F = 0, and p_k the generalised
impulses (nv,) of everything else, such as torsional and rolling friction. A step of an engine is

    M (v+ - v0) = J' r + F' lam + sum_k p_k,

where v0 is the engine's velocity after the step without constraints. The captured problem has v* = v0 + M^-1 sum_k p_k, so that
the p_k act as in the engine. A note for each p_k states its share, |p_k| divided by the sum of |J' r|, |F' lam| and all |p_k|.
The norm is that of M^-1, in which translations and rotations can be added. b_F = -F v+, because the engine's equations are soft
and its answer moves them by this. The note for a constraint J v = a - R f of softness R states the share of f'R f in
f'R f + |J' f|^2, which is 0 for a rigid one.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array, require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.native import EngineStep

VELOCITY_ERROR = 1e-9  # relative to the velocities: the allowed error of a captured step's velocity
UNEXPLAINED = "other forces, the integrator, the solver's tolerance"  # such as adhesion and unsymmetric implicit terms
LEAST_SHARE = 1e-9  # smaller shares are rounding errors
LEAST_IMPULSE = 1e-13  # relative to the momentum: smaller impulses are rounding errors
LEAST_ENTRY = 1e-14  # relative to sqrt(M_ii M_jj): smaller entries of M are rounding errors of the engine


class Contacts(NamedTuple):
    """The contacts of a step, followed by its limits and its dry friction in the conventions of FrictionProblem.

    rows: (3 nc, nv), normal first. impulse: (nc, 3), N s. friction: (nc,). gap: (nc,), m. loss: (nc,), N s, the friction bias.
    """

    rows: Array
    impulse: Array
    friction: Array
    gap: Array
    loss: Array

    def and_limits(self, rows: Array, impulse: Array, gap: Array) -> "Contacts":
        """The contacts with additional limits: rows (n, nv), impulse (n,), gap (n,)."""
        return self._joined(0, rows, impulse, gap, np.zeros(len(rows)))

    def and_dry_friction(self, rows: Array, impulse: Array, loss: Array, step: float) -> "Contacts":
        """The contacts with additional dry friction: rows (n, nv), impulse (n,), loss (n,), N s; step, s, makes the bias 1."""
        return self._joined(1, rows, impulse, np.full(len(rows), step), loss)

    def _joined(self, place: int, rows: Array, impulse: Array, gap: Array, loss: Array) -> "Contacts":
        three, used = np.zeros((len(rows), 3, rows.shape[1])), np.zeros((len(rows), 3))
        three[:, place], used[:, place] = rows, impulse
        added = three.reshape(-1, rows.shape[1]), used, np.zeros(len(rows)), gap, loss
        return Contacts(*(np.concatenate(pair) for pair in zip(self, added, strict=True)))


class Step(NamedTuple):
    """mass: (nv, nv), for impulses. free, velocity: (nv,), after the step, without and with constraints. length: s.

    equations: F (nj, nv). others: p_k by name. softness: shares of softness, by name.
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

    Errors: InputError if the step is not finite, if mass is not positive definite, or if the problem's velocity differs from
    the engine's.
    """
    require_finite(step.mass, step.free, step.velocity)
    mass = without_noise(step.mass)
    inverse = np.asarray(np.linalg.inv(mass), dtype=np.float64)
    contacts, F = step.contacts, step.equations
    pushed = contacts.rows.T @ contacts.impulse.ravel()
    whole = mass @ (step.velocity - step.free)
    held = whole - pushed - sum(step.others.values(), np.zeros(len(mass)))
    by_equations, rest = _by_equations(F, inverse, held)
    others = {**step.others, UNEXPLAINED: rest}
    sizes = {name: _size(inverse, impulse) for name, impulse in others.items()}
    total = _size(inverse, pushed) + _size(inverse, by_equations) + sum(sizes.values())
    least = max(LEAST_SHARE * total, LEAST_IMPULSE * _size(inverse, mass @ (np.abs(step.velocity) + np.abs(step.free))))
    notes = {name: size / total for name, size in sizes.items() if size > least}
    free = step.free + inverse @ sum(others.values())
    problem = posed(mass, free, contacts, contacts.gap / step.length, F, -F @ step.velocity)
    miss = float(np.abs(problem.velocity(contacts.impulse) - step.velocity).max(initial=0))
    scale = max(1.0, float(np.abs(step.velocity).max(initial=0)), float(np.abs(step.free).max(initial=0)))
    require(miss <= VELOCITY_ERROR * scale, "step", f"the captured problem misses the engine's next velocity by {miss:.1e}")
    notes |= {name: share for name, share in step.softness.items() if share > LEAST_SHARE}
    return EngineStep(problem, contacts.impulse, notes, step.length)


def posed(mass: Array, free: Array, contacts: Contacts, bias: Array, F: Array, joint_bias: Array) -> FrictionProblem:
    """The problem with these contacts and joint equations F v + joint_bias = 0."""
    J, F = (np.where(np.abs(rows) > LEAST_ENTRY * np.abs(rows).max(initial=0.0), rows, 0.0) for rows in (contacts.rows, F))
    rows = J.reshape(-1, 3, len(mass))
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
    """Errors: InputError if one of a step's arrays contains an infinity or a NaN."""
    finite = all(np.isfinite(array).all() for array in arrays)
    require(finite, "data", "masses, forces or velocities are not finite: the simulation has diverged")


def share_of_softness(mass: Array, pushed: Array, soft: float) -> float:
    """f'R f / (f'R f + |J' f|^2), with the norm of M^-1, pushed J' f (nv,) and soft f'R f; 0 without forces."""
    rigid = float(pushed @ np.linalg.solve(mass, pushed))
    return soft / (soft + rigid) if soft > 0 else 0.0


def _by_equations(F: Array, inverse: Array, held: Array) -> tuple[Array, Array]:
    """The projection of held onto the range of F' in the norm of M^-1, and the rest."""
    if not len(F):
        return np.zeros_like(held), held
    root = np.linalg.cholesky(inverse)  # |p| in M^-1 is |root' p|
    lam = np.linalg.lstsq(root.T @ F.T, root.T @ held, rcond=None)[0]
    return F.T @ lam, held - F.T @ lam


def _size(inverse: Array, impulse: Array) -> float:
    return float(np.sqrt(abs(impulse @ inverse @ impulse)))


def without_noise(mass: Array) -> Array:
    """The symmetric part of the mass matrix without entries that are rounding errors, so that separate bodies stay separate."""
    symmetric = (mass + mass.T) / 2
    size: Array = np.sqrt(np.abs(np.diag(symmetric)))
    return np.where(np.abs(symmetric) > LEAST_ENTRY * np.outer(size, size), symmetric, 0.0)
