"""Accelerated projected gradient descent on the relaxation's dual, and on Coulomb's law itself.

The convex relaxation's impulses minimise  ½ r'W r + q'r  over the product K of the contacts' cones, a problem whose gradient is
the contact velocity u and whose projections are made contact by contact. In the metric of the contacts' scales s, one step is

    r+ = P_K(y - u(y)/(L s)),    y+ = r+ + beta (r+ - r),    beta from Nesterov's theta+^2 = (1 - theta+) theta^2,

with L doubled until (r+ - y)'W(r+ - y) <= L sum_i s_i |r+ - y|_i^2 and let down by a tenth a step, and theta set back to 1
whenever the step goes uphill, u(y)'(r+ - r) > 0. One product with W an iteration: u is affine, so that u(y+) needs none.

`apgd_coulomb` takes the same steps along de Saxcé's shifted velocity u + mu |u_t| e_n. Its fixed points are Coulomb solutions,
it is no gradient, and no convergence is known.

References: Nesterov 1983; O'Donoghue and Candès 2015 for the restart; Mazhar, Heyn, Negrut and Tasora 2015.
"""

import numpy as np
from numba import njit

from problems import FrictionProblem
from problems.check import Array
from problems.forms.cone import nearest
from solvers.interface import Answer, impulses, solver
from solvers.sweeps.form import ContactForm, contact_form, state, velocity
from solvers.sweeps.laws import defect
from solvers.sweeps.stopping import ENDS, GOING, ended, progress

LIMIT = 20_000
PATIENCE = 5000  # iterations in which the residual must fall by a hundredth


@solver("apgd", family="splitting", model="relaxation", dimension=(2, 3), warm_start=True, sparse=True)
class APGD:
    """Accelerated projected gradient descent on the convex relaxation's dual.

    Work: iterations, and products with W. History: the relaxation's residual at every iteration.
    """

    shift = 0.0

    def form(self, problem: FrictionProblem) -> ContactForm:
        return contact_form(problem)

    def solve(self, prepared: ContactForm, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        limit = LIMIT if limit is None else limit
        r = impulses(start, prepared.offset.shape)
        history = np.empty(limit + 1)
        end, iterations, products = descend(prepared, r, self.shift, tol, limit, history, progress())
        work = {"iterations": iterations, "products": products}
        return Answer(r, ENDS[end], work, tuple(history[: iterations + 1].tolist()))


@solver("apgd_coulomb", family="splitting", model="coulomb", dimension=(2, 3), warm_start=True, sparse=True)
class APGDCoulomb(APGD):
    """Accelerated projected gradient steps along de Saxcé's shifted velocity.

    Work: iterations, and products with W. History: the residual at every iteration.
    """

    shift = 1.0


@njit(cache=True, error_model="numpy")
def descend(form, r, shift, tol, limit, history, best):  # type: ignore[no-untyped-def]
    """Overwrite r by the solution. Returns the index of the status, the iterations and the products with W."""
    x, u, u_next, u_y = np.empty_like(form.rest), np.empty_like(r), np.empty_like(r), np.empty_like(r)
    y, r_next = r.copy(), np.empty_like(r)
    state(form, r, x)
    velocity(form, x, u)
    u_y[:] = u
    L, theta, products = 1.0, 1.0, 1
    iteration = 0
    while True:
        error = defect(form, r, u, shift)
        history[iteration] = error
        end = ended(error, tol, iteration, limit, PATIENCE, best)
        if end != GOING:
            break
        while True:
            step(form, r_next, y, u_y, shift, 1 / L)
            state(form, r_next, x)
            velocity(form, x, u_next)
            products += 1
            curvature, length = 0.0, 0.0
            for i in range(len(r)):
                for j in range(r.shape[1]):
                    move = r_next[i, j] - y[i, j]
                    curvature += move * (u_next[i, j] - u_y[i, j])
                    length += form.scale[i] * move * move
            if not curvature > L * length:
                break
            L = max(2 * L, curvature / length)
        uphill = 0.0
        for i in range(len(r)):
            for j in range(r.shape[1]):
                uphill += u_y[i, j] * (r_next[i, j] - r[i, j])
        if uphill > 0:
            theta = 1.0
        theta_next = (theta * np.sqrt(theta * theta + 4) - theta * theta) / 2
        beta = theta * (1 - theta) / (theta * theta + theta_next)
        theta = theta_next
        y[:] = r_next + beta * (r_next - r)
        u_y[:] = u_next + beta * (u_next - u)
        r[:] = r_next
        u[:] = u_next
        L *= 0.9
        iteration += 1
    return end, iteration, products


@njit(cache=True, error_model="numpy")
def step(form, r, y, u, shift, length):  # type: ignore[no-untyped-def]
    """r = P_K(y - length (u + shift mu |u_t| e_n) / s), contact by contact."""
    d = r.shape[1]
    for i in range(len(r)):
        mu, b_f, tau = form.friction[i], form.friction_bias[i], length / form.scale[i]
        slide, size = 0.0, 0.0
        for j in range(1, d):
            slide += u[i, j] ** 2
            r[i, j] = y[i, j] - tau * u[i, j]
            size += r[i, j] ** 2
        n = y[i, 0] - tau * (u[i, 0] + shift * mu * np.sqrt(slide))
        r[i, 0], share = nearest(n, np.sqrt(size), mu, b_f)
        for j in range(1, d):
            r[i, j] *= share
