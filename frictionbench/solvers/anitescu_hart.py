"""A fixed-point iteration of convex relaxations whose fixed points obey Coulomb's law.

    r^k solves the relaxation with u_n replaced by u_n + mu lam^k,     lam^{k+1} = |u_t(r^k)|.

The relaxation keeps u_n + mu lam^k >= mu |u_t| at every contact. If lam is stationary, both shifts cancel, and u_n = 0 wherever
r_n > 0: a fixed point is a Coulomb solution. The iteration contracts for small mu. For one contact with the block
[[a, b], [b, g]] that slides along +t, the rate is |mu (mu g - b)|/(a - 2 mu b + mu^2 g); at a rate of 1 or more it can end in a
cycle of period two, and stalls.

Each relaxation is solved by accelerated projected gradients (solvers.sweeps.projected_gradient) from the last impulses, until
its error is INNER times the present residual.

References: Anitescu and Hart 2004; Acary, Cadoux, Lemaréchal and Malick 2011 in space.
"""

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, impulses, solver
from frictionbench.solvers.sweeps.form import ContactForm, contact_form
from frictionbench.solvers.sweeps.laws import residual_at
from frictionbench.solvers.sweeps.projected_gradient import relax
from frictionbench.solvers.sweeps.stopping import monitor, should_continue

LIMIT = 500  # relaxations by default: convergence is linear, and slower rates stall first (PATIENCE)
PATIENCE = 100  # relaxations in which the residual must fall by a hundredth: a fifth of the limit
INNER = 0.1  # error of each relaxation relative to the residual at its start: less costs products, more costs relaxations
INNER_LIMIT = 300  # products: impulses that are not unique still change when the velocities have long converged


@solver("anitescu_hart", family="splitting", model="coulomb", dimension=(2, 3), warm_start=True)
class AnitescuHart:
    """Anitescu and Hart's fixed point: a sequence of convex relaxations, each shifted by the last one's sliding.

    Work: relaxations, and products with W in the inner solves. History: the residual before every relaxation.
    """

    def form(self, problem: FrictionProblem) -> ContactForm:
        return contact_form(problem)

    def solve(self, form: ContactForm, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        r, monitored = impulses(start, form.offset.shape), monitor(tol, LIMIT if limit is None else limit, PATIENCE)
        shifted = form._replace(offset=form.offset.copy())
        x, u = np.empty_like(form.rest), np.empty_like(r)
        relaxations, products = 0, 1  # a check of the residual is one
        while should_continue(monitored, error := residual_at(form, r, x, u, 1.0), relaxations):
            shifted.offset[:, 0] = form.offset[:, 0] + form.friction * np.linalg.norm(u[:, 1:], axis=1)  # lam = |u_t|
            products += 1 + relax(shifted, r, INNER * error, INNER_LIMIT)
            relaxations += 1
        return monitored.answer(r, relaxations=relaxations, products=products)
