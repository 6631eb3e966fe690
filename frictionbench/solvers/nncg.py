"""Nonlinear nonsmooth conjugate gradients over Gauss-Seidel sweeps.

One sweep of nonsmooth Gauss-Seidel, r -> G(r), has the solutions as its fixed points; its step g = G(r) - r is treated as minus
the gradient of an unknown function, and Fletcher and Reeves' conjugate directions are applied to it:

    g+ = G(r) - r,    beta = |g+|^2 / |g|^2, taken as 0 where it is 1 or more,    r+ = G(r) + beta p,    p+ = g+ + beta p,

in the metric of the contacts' scales s_i. An iteration costs one sweep and a few vector updates; the state x = rest + R r is
updated by the same linear combinations. No convergence theorem is known.

Reference: Silcowitz, Niebe and Erleben 2010.
"""

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.solvers.interface import Answer, impulses, solver
from frictionbench.solvers.sweeps.form import ContactForm, contact_form
from frictionbench.solvers.sweeps.gauss_seidel import CHECK, monitor_sweeps, planar_sweeps, spatial_sweeps
from frictionbench.solvers.sweeps.laws import residual_at
from frictionbench.solvers.sweeps.stopping import should_continue


@solver("nncg", family="splitting", model="coulomb", dimension=(2, 3), warm_start=True)
class NNCG:
    """Nonlinear nonsmooth conjugate gradients over Gauss-Seidel sweeps.

    Work: sweeps over all contacts, and checks of the residual. History: the residual at the start and after every tenth sweep.
    """

    def form(self, problem: FrictionProblem) -> ContactForm:
        return contact_form(problem)

    def solve(self, form: ContactForm, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        r, monitor = impulses(start, form.offset.shape), monitor_sweeps(tol, limit)
        sweeps = _iterate(form, r, monitor)
        return monitor.answer(r, sweeps=sweeps, checks=monitor.seen)


@kernel
def _iterate(form, r, monitor):  # type: ignore[no-untyped-def]
    """Overwrite r with the solution; return the number of sweeps."""
    x, u = np.empty_like(form.rest), np.empty_like(r)
    p, p_x = np.zeros_like(r), np.zeros_like(x)
    r_old, x_old = np.empty_like(r), np.empty_like(x)
    sweeps, size = 0, 0.0
    while should_continue(monitor, residual_at(form, r, x, u, 1.0), sweeps):
        for _ in range(min(CHECK, monitor.limit - sweeps)):
            r_old[:], x_old[:] = r, x
            if r.shape[1] == 2:
                planar_sweeps(form, r, x, 1.0, 1)
            else:
                spatial_sweeps(form, r, x, 1.0, 1)
            sweeps += 1
            size_old, size = size, 0.0
            for i in range(len(r)):
                for j in range(r.shape[1]):
                    size += form.scale[i] * (r[i, j] - r_old[i, j]) ** 2
            r_old[:], x_old[:] = r - r_old, x - x_old
            if size < size_old:
                beta = size / size_old
                r += beta * p
                x += beta * p_x
                p[:], p_x[:] = r_old + beta * p, x_old + beta * p_x
            else:
                p[:], p_x[:] = r_old, x_old
    return sweeps
