"""Accelerated projected gradient steps on a problem in contact-wise form.

In the metric of the contacts' scales s, one step is

    r+ = P_K(y - u(y)/(L s)),    y+ = r+ + beta (r+ - r),    beta from Nesterov's theta+^2 = (1 - theta+) theta^2,

where L is doubled until (r+ - y)'W(r+ - y) <= L sum_i s_i |r+ - y|_i^2 and reduced by a tenth after each step, and theta is
reset to 1 whenever a step goes uphill, u(y)'(r+ - r) > 0. A trial step costs one product with W; u is affine: u(y+) needs none.
"""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.cone import nearest
from frictionbench.solvers.sweeps.form import ContactForm, state, velocity
from frictionbench.solvers.sweeps.laws import defect
from frictionbench.solvers.sweeps.stopping import monitor, should_continue

PATIENCE = 5000  # iterations in which the residual must fall by a hundredth: a quarter of the limit of apgd


def relax(form: ContactForm, r: Array, tol: float, limit: int) -> int:
    """Overwrite r (nc, d) with a solution of the convex relaxation; return the number of products with W."""
    return int(descend(form, r, 0.0, monitor(tol, limit, PATIENCE))[1])


@kernel
def descend(form, r, shift, monitor):  # type: ignore[no-untyped-def]
    """Overwrite r with the solution; return the numbers of iterations and of products with W."""
    x, u, u_next, u_y = np.empty_like(form.rest), np.empty_like(r), np.empty_like(r), np.empty_like(r)
    y, r_next = r.copy(), np.empty_like(r)
    state(form, r, x)
    velocity(form, x, u)
    u_y[:] = u
    L, theta = 1.0, 1.0
    iterations, products = 0, 1
    while should_continue(monitor, defect(form, r, u, shift), iterations):
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
        for i in range(len(r)):
            for j in range(r.shape[1]):
                y[i, j] = r_next[i, j] + beta * (r_next[i, j] - r[i, j])
                u_y[i, j] = u_next[i, j] + beta * (u_next[i, j] - u[i, j])
        r[:], u[:] = r_next, u_next
        L *= 0.9
        iterations += 1
    return iterations, products


@part
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
