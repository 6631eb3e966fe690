"""Nonsmooth Gauss-Seidel: Coulomb's law solved exactly at one contact after the other.

    repeat   for i = 1..nc:   r_i <- the solution of contact i's law, the others held;   x += R_i (r_i+ - r_i)

Fixed points are exactly the Coulomb solutions. No convergence theorem: one sliding contact converges at the linear rate
mu|b|/a, a sticking one at b^2/(a g) if its two laws are solved apart; here they are solved at once, so that a single contact
takes one sweep. Between contacts the rate remains, and tall stacks and heavy bodies on light ones make it slow.

In velocities a planar contact of two bodies costs 12 products to read, about 20 operations to solve and 12 products to push:
some 25 ns on one core of a server, within a fifth of the same loop in C (gcc -O3).

References: Jourdan, Alart and Jean 1998; Jean 1999.
"""

import numpy as np
from numba import njit

from problems import FrictionProblem
from problems.check import Array, require
from solvers.interface import Answer, impulses, solver
from solvers.sweeps.form import ContactForm, contact_form, state, velocity
from solvers.sweeps.laws import defect, planar_contact, spatial_contact
from solvers.sweeps.stopping import ENDS, GOING, ended, progress

LIMIT = 10_000
CHECK = 10  # sweeps between two residuals, each with the state computed anew
PATIENCE = 2500  # sweeps in which the residual must fall by a hundredth


@solver("nsgs", family="splitting", model="coulomb", dimension=(2, 3), warm_start=True, sparse=True)
class NSGS:
    """Nonsmooth Gauss-Seidel: solve each contact's friction law in turn.

    relaxation: factor in (0, 2) on every change of an impulse.
    Work: sweeps over all contacts, and checks of the residual. History: the residual at the start and after every tenth sweep.
    """

    relaxation: float = 1.0

    def __post_init__(self) -> None:
        require(0 < self.relaxation < 2, "relaxation", f"must lie between 0 and 2, got {self.relaxation!r}")

    def form(self, problem: FrictionProblem) -> ContactForm:
        return contact_form(problem)

    def solve(self, prepared: ContactForm, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        limit = LIMIT if limit is None else limit
        r = impulses(start, prepared.offset.shape)
        history = np.empty(2 + limit // CHECK)
        end, sweeps, checks = _iterate(prepared, r, self.relaxation, tol, limit, history, progress())
        return Answer(r, ENDS[end], {"sweeps": sweeps, "checks": checks}, tuple(history[:checks].tolist()))


@njit(cache=True)
def _iterate(form, r, relaxation, tol, limit, history, best):  # type: ignore[no-untyped-def]
    """Sweep until the residual is at most tol. Returns the index of the status, the sweeps and the number of checks."""
    x, u = np.empty_like(form.rest), np.empty_like(r)
    sweeps, checks = 0, 0
    while True:
        state(form, r, x)
        velocity(form, x, u)
        error = defect(form, r, u, 1.0)
        history[checks] = error
        checks += 1
        end = ended(error, tol, sweeps, limit, PATIENCE, best)
        if end != GOING:
            return end, sweeps, checks
        count = min(CHECK, limit - sweeps)
        if r.shape[1] == 2:
            planar_sweeps(form, r, x, relaxation, count)
        else:
            spatial_sweeps(form, r, x, relaxation, count)
        sweeps += count


@njit(cache=True)
def planar_sweeps(form, r, x, relaxation, count):  # type: ignore[no-untyped-def]
    """Sweeps over planar contacts; r (nc, 2) and the state x are brought up to date."""
    for _ in range(count):
        for i in range(len(r)):
            u_n, u_t = form.offset[i, 0], form.offset[i, 1]
            for k in range(form.read_start[i], form.read_start[i + 1]):
                at = x[form.read_column[k]]
                u_n += form.read[k, 0] * at
                u_t += form.read[k, 1] * at
            n, t = planar_contact(u_n, u_t, r[i, 0], r[i, 1], form.block[i], form.friction[i], form.friction_bias[i])
            change_n, change_t = relaxation * (n - r[i, 0]), relaxation * (t - r[i, 1])
            r[i, 0] += change_n
            r[i, 1] += change_t
            for k in range(form.push_start[i], form.push_start[i + 1]):
                x[form.push_column[k]] += form.push[k, 0] * change_n + form.push[k, 1] * change_t


@njit(cache=True)
def spatial_sweeps(form, r, x, relaxation, count):  # type: ignore[no-untyped-def]
    """Sweeps over spatial contacts; r (nc, 3) and the state x are brought up to date."""
    u, change = np.empty(3), np.empty(3)
    for _ in range(count):
        for i in range(len(r)):
            u[:] = form.offset[i]
            for k in range(form.read_start[i], form.read_start[i + 1]):
                for j in range(3):
                    u[j] += form.read[k, j] * x[form.read_column[k]]
            change[:] = r[i]
            spatial_contact(u, change, form.block[i], form.friction[i], form.friction_bias[i])
            for j in range(3):
                change[j] = relaxation * (change[j] - r[i, j])
                r[i, j] += change[j]
            for k in range(form.push_start[i], form.push_start[i + 1]):
                for j in range(3):
                    x[form.push_column[k]] += form.push[k, j] * change[j]
