"""Gauss-Seidel sweeps: Coulomb's law is solved exactly at one contact after the other, with all other impulses fixed.

With velocities as the state, a planar contact of two bodies costs 12 products to read, about 20 operations to solve and 12
products to push: some 25 ns on one core of a server, within a fifth of the same loop in C (gcc -O3).
"""

import numpy as np

from frictionbench.problems.compiled import part
from frictionbench.solvers.sweeps.laws import planar_contact, spatial_contact
from frictionbench.solvers.sweeps.stopping import Monitor, monitor

LIMIT = 10_000  # sweeps by default: a quarter of a second for a thousand planar contacts
CHECK = 10  # sweeps between two checks of the residual, which recompute the state and take a tenth of the sweeps' time
SLOWLY = 2500, 0.99  # sweeps in which the residual must fall to this share: a quarter of the limit
QUICKLY = 10, 0.3  # the same where other methods follow: faster than these, or a good start for them


def monitor_sweeps(tol: float, limit: int | None, pace: tuple[int, float] = SLOWLY) -> Monitor:
    """A monitor of at most limit sweeps, LIMIT by default. pace: SLOWLY or QUICKLY."""
    return monitor(tol, LIMIT if limit is None else limit, pace[0], CHECK, pace[1])


@part
def planar_sweeps(form, r, x, relaxation, count):  # type: ignore[no-untyped-def]
    """`count` sweeps over planar contacts; the impulses r (nc, 2) and the state x are updated."""
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


@part
def spatial_sweeps(form, r, x, relaxation, count):  # type: ignore[no-untyped-def]
    """The same as planar_sweeps for spatial contacts, r (nc, 3)."""
    u, change = np.empty(3, r.dtype), np.empty(3, r.dtype)
    for _ in range(count):
        for i in range(len(r)):
            for j in range(3):
                u[j], change[j] = form.offset[i, j], r[i, j]
            for k in range(form.read_start[i], form.read_start[i + 1]):
                for j in range(3):
                    u[j] += form.read[k, j] * x[form.read_column[k]]
            spatial_contact(u, change, form.block[i], form.friction[i], form.friction_bias[i])
            for j in range(3):
                change[j] = relaxation * (change[j] - r[i, j])
                r[i, j] += change[j]
            for k in range(form.push_start[i], form.push_start[i + 1]):
                for j in range(3):
                    x[form.push_column[k]] += form.push[k, j] * change[j]
