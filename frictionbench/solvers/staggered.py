"""Staggered projections: a normal and a friction problem in turn, each convex, with the impulses of the other held fixed.

    r_n = argmin ½ r_n'W_nn r_n + (q_n + W_nt r_t)'r_n    over r_n >= 0,
    r_t = argmin ½ r_t'W_tt r_t + (q_t + W_tn r_n)'r_t    over |r_t,i| <= mu_i r_n,i + b_f,i,

until both hold at once, which is Coulomb's law exactly: the second states that friction dissipates maximally. No convergence
theorem is known; a single sliding contact contracts by mu|b|/a (b = W_nt, a = W_nn).

Both are contact problems themselves: the first without tangents, the second without normals, with mu = 0 and the friction bias
mu r_n + b_f. Each is solved by accelerated projected gradients (solvers.sweeps.projected_gradient) from its last result, to a
fraction INNER of the present residual. The solution of the friction problem need not be unique, but its velocity is.

Reference: Kaufman, Sueda, James and Pai 2008.
"""

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, impulses, solver
from frictionbench.solvers.sweeps.form import ContactForm, contact_form, state
from frictionbench.solvers.sweeps.laws import residual_at
from frictionbench.solvers.sweeps.projected_gradient import relax
from frictionbench.solvers.sweeps.stopping import monitor, should_continue

LIMIT = 1000  # rounds by default; convergence is linear, and slower rates stall first (PATIENCE)
PATIENCE = 200  # rounds in which the residual must fall by a hundredth: a fifth of the limit
INNER = 0.1  # error of each half relative to the residual at its start: less costs products, more costs rounds
INNER_LIMIT = 5000  # iterations of a half; the next round continues from its result


@solver("staggered", family="splitting", model="coulomb", dimension=(2, 3), warm_start=True)
class Staggered:
    """Staggered projections: alternate the normal and the friction problem.

    Work: rounds, and products with W, including those of the inner solves. History: the residual before every round.
    """

    def form(self, problem: FrictionProblem) -> ContactForm:
        return contact_form(problem)

    def solve(self, form: ContactForm, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        r, monitored = impulses(start, form.offset.shape), monitor(tol, LIMIT if limit is None else limit, PATIENCE)
        normal, friction = _only(form, [0]), _only(form, range(1, r.shape[1]))
        n, t, u, x = np.zeros_like(r), np.zeros_like(r), np.empty_like(r), np.empty_like(form.rest)
        n[:, 0], t[:, 1:] = r[:, 0], r[:, 1:]
        rounds, products = 0, 1  # a check of the residual is one
        while should_continue(monitored, error := residual_at(form, n + t, x, u, 1.0), rounds):
            state(form, t, normal.rest)
            products += relax(normal, n, INNER * error, INNER_LIMIT)
            state(form, n, friction.rest)
            friction.friction_bias[:] = form.friction * n[:, 0] + form.friction_bias
            products += relax(friction, t, INNER * error, INNER_LIMIT)
            products += 3  # the state of each half, from which the other starts, and the next check
            rounds += 1
        return monitored.answer(n + t, rounds=rounds, products=products)


def _only(form: ContactForm, rows: range | list[int]) -> ContactForm:
    """The same contacts with these rows of u and r only; the others stay zero. Friction is a bias, which is yet to be set."""
    keep = np.zeros(form.offset.shape[1])
    keep[rows] = 1
    diagonal = np.einsum("ijj,j->i", form.block, keep) / keep.sum()
    return form._replace(
        read=form.read * keep,
        push=form.push * keep,
        offset=form.offset * keep,
        rest=form.rest.copy(),
        friction=np.zeros_like(form.friction),
        friction_bias=np.zeros_like(form.friction),
        scale=np.where(diagonal > 0, diagonal, 1.0),
    )
