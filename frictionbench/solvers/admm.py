"""Alternating direction method of multipliers: one copy of the impulses obeys the dynamics, the other stays in the cones.

    (W + rho S) r = rho S z - q - mu |w_t| e_n - w        the dynamics, one sparse factorisation for all iterations
    z+ = P_K(r^ + w/(rho S)),    r^ = alpha r + (1-alpha) z    the cones, contact by contact
    w+ = w + rho S (r^ - z+)                              the multiplier, -(u + mu |u_t| e_n) at the end

where S = diag(s_i) holds the contacts' scales, so that rho is dimensionless, and alpha is the over-relaxation. The term
mu |w_t| e_n is de Saxcé's shift: with it the fixed points are Coulomb's solutions (`admm_coulomb`, no convergence theorem),
without it those of the convex relaxation (`admm`, which converges for every fixed rho). rho is multiplied by the root of the
ratio of the two residuals, |r - z| and rho |z+ - z|, which costs a factorisation each time. Between two changes the number of
iterations must at least double, so that rho converges.

References: Boyd, Parikh, Chu, Peleato and Eckstein 2011, sections 3.3 and 3.4; Tasora, Mangoni, Benatti and Garziera 2021;
Carpentier, Le Lidec and Montaut 2024.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.rows import Index32, Index64
from frictionbench.solvers.clock import deadline, is_past
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.sparse_lu.multifrontal import (
    Fronts,
    analyse,
    factorise,
    operations,
    place_of_entry,
    solve_factorised,
)
from frictionbench.solvers.sweeps.form import ContactForm, asked, begin, contact_form, single
from frictionbench.solvers.sweeps.laws import residual_at
from frictionbench.solvers.sweeps.projected_gradient import step
from frictionbench.solvers.sweeps.stopping import monitor, should_continue

LIMIT = 10_000  # iterations by default, as many as sweeps of nsgs
PATIENCE = 2500  # iterations in which the residual must fall by a hundredth: a quarter of the limit
CHECK = 10  # iterations between two checks of the residual, whose cost is then a tenth of an iteration's
ALPHA = 1.6  # over-relaxation: 1.5 to 1.8 is recommended (Boyd et al. 2011, section 3.4.3)
RHO = 0.1  # initial penalty, relative to the scales S; adapted afterwards, as OSQP does from the same value
RETUNE = 2.0  # least change of rho, as a factor, that justifies a factorisation
SHIFTED_PIVOT = 1e-3  # the least pivot, relative to rho S: W has no negative eigenvalue, so that smaller pivots are rounding


class Factor(NamedTuple):
    """Sparse factors of W + rho S and their symbolic factorisation (solvers.sparse_lu.multifrontal).

    place (nc*d,): position of each row in the order of elimination. slot: index in storage of each entry of the blocks of W.
    storage, swap: the factors for one rho. right (nc*d,): workspace.
    """

    fronts: Fronts
    place: Index64
    slot: Index64
    storage: Array
    swap: Index64
    right: Array


# The packed problem; W by contacts (problems.rows), and q (nc, d).
Formed = tuple[ContactForm, tuple[Index32, Index32, Array], Array]
Prepared = tuple[Formed, Factor | None]  # None if the deadline leaves no time for a factorisation


@solver("admm", family="splitting", model="relaxation", dimension=(2, 3), warm_start=True)
class ADMM:
    """Alternating direction method of multipliers on the convex relaxation's dual.

    precision: double or single, also of the factors.
    Work: iterations, factorisations including that of the setup, and checks of the residual. History: the relaxation's
    residual every tenth iteration.
    """

    precision: str = "double"

    shift = 0.0

    def form(self, problem: FrictionProblem) -> Formed:
        form = contact_form(problem, relaxed=not self.shift, precision=self.precision)
        (first, neighbours, block), q = problem.blocks, problem.q.reshape(-1, problem.dimension)
        if self.precision == "single":
            block, q = single(block), single(q)
        return form, (first, neighbours, block), q

    def setup(self, formed: Formed) -> Prepared:
        form, W, _ = formed
        factor = _lay_out(*W)
        if is_past(deadline(operations(factor.fronts))):
            return formed, None
        return formed, _factorise(factor, W[2], form.scale, RHO)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        (form, W, q), factor = prepared
        z, rho = begin(form, start), RHO
        if factor is None:
            return Answer(np.asarray(z, float), Status.TIME_LIMIT, {"iterations": 0, "factorisations": 0, "checks": 0})
        last = deadline(operations(factor.fronts))
        monitored = monitor(asked(form, tol), LIMIT if limit is None else limit, PATIENCE, CHECK)
        x, u, w = np.empty_like(form.rest), np.empty_like(z), np.empty_like(z)
        iterations, factorisations, retune = 0, 1, 0
        while should_continue(monitored, residual_at(form, z, x, u, self.shift), iterations):
            if iterations == 0:
                w[:] = -u
                w[:, 0] -= self.shift * form.friction * np.linalg.norm(u[:, 1:], axis=1)
            count = min(CHECK, monitored.limit - iterations)
            primal, dual = _alternate(form, factor, q, rho, self.shift, z, w, count)
            iterations += count
            ratio = (primal / dual) ** 0.25 if primal > 0 and dual > 0 else 1.0
            if iterations >= retune and not 1 / RETUNE < ratio < RETUNE and not is_past(last):
                retune = 2 * iterations
                rho = float(np.clip(rho * ratio, 1e-6, 1e6))
                factor = _factorise(factor, W[2], form.scale, rho)
                factorisations += 1
        return monitored.answer(z, iterations=iterations, factorisations=factorisations, checks=monitored.seen)


@solver("admm_coulomb", family="splitting", model="coulomb", dimension=(2, 3), warm_start=True)
class ADMMCoulomb(ADMM):
    """Alternating direction method of multipliers with de Saxcé's shift.

    precision: double or single, also of the factors.
    Work: iterations, factorisations including that of the setup, and checks of the residual. History: the residual every
    tenth iteration.
    """

    shift = 1.0


@kernel
def _lay_out(first, neighbours, block):  # type: ignore[no-untyped-def]
    """The Factor of W (nc, nc blocks of d by d) before factorisation; each pair of coupled contacts is an element."""
    nc, d = len(first) - 1, block.shape[1]
    start, member = np.empty(len(neighbours) + 1, np.int64), np.empty(2 * d * len(neighbours), np.int64)
    start[0] = at = 0
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            for a in range(d):
                member[at] = i * d + a
                at += 1
            for a in range(d if neighbours[k] != i else 0):
                member[at] = neighbours[k] * d + a
                at += 1
            start[k + 1] = at
    fronts, place, _ = analyse(start, member[:at], nc * d)
    slot, at = np.empty(len(neighbours) * d * d, np.int64), 0
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            for a in range(d):
                for b in range(d):
                    slot[at] = place_of_entry(fronts, place[i * d + a], place[neighbours[k] * d + b])
                    at += 1
    return Factor(fronts, place, slot, np.empty(0, block.dtype), np.empty(nc * d, np.int64), np.empty(nc * d, block.dtype))


@kernel
def _factorise(factor, block, scale, rho):  # type: ignore[no-untyped-def]
    """Factorise W + rho S. block: the blocks of W."""
    fronts, storage, d = factor.fronts, np.zeros(factor.fronts.start[-1], block.dtype), block.shape[1]
    swap = np.empty_like(factor.swap)
    entry = block.ravel()
    for k in range(len(entry)):
        storage[factor.slot[k]] += entry[k]
    least = np.inf
    for i in range(len(scale)):
        least = min(least, rho * scale[i])
        for a in range(i * d, i * d + d):
            storage[place_of_entry(fronts, factor.place[a], factor.place[a])] += rho * scale[i]
    factorise(fronts, storage, swap, SHIFTED_PIVOT * least)
    return Factor(fronts, factor.place, factor.slot, storage, swap, factor.right)


@part
def _solve(factor, b):  # type: ignore[no-untyped-def]
    """Overwrite b with (W + rho S)^-1 b."""
    for i in range(len(b)):
        factor.right[factor.place[i]] = b[i]
    solve_factorised(factor.fronts, factor.storage, factor.swap, factor.right)
    for i in range(len(b)):
        b[i] = factor.right[factor.place[i]]


@kernel
def _alternate(form, factor, q, rho, shift, z, w, count):  # type: ignore[no-untyped-def]
    """`count` iterations on z and w (nc, d). Returns the squares of the last primal and dual residuals."""
    nc, d = z.shape
    r, z_old = np.empty_like(z), np.empty_like(z)
    primal, dual = 0.0, 0.0
    for _ in range(count):
        for i in range(nc):
            slide = 0.0
            for j in range(d):
                slide += w[i, j] ** 2 if j else 0.0
                r[i, j] = rho * form.scale[i] * z[i, j] - q[i, j] - w[i, j]
            r[i, 0] -= shift * form.friction[i] * np.sqrt(slide)
        _solve(factor, r.reshape(nc * d))
        z_old[:] = z
        r[:] = ALPHA * r + (1 - ALPHA) * z
        step(form, z, r, -w, 0.0, 1 / rho)
        primal, dual = 0.0, 0.0
        for i in range(nc):
            for j in range(d):
                w[i, j] += rho * form.scale[i] * (r[i, j] - z[i, j])
                primal += form.scale[i] * (r[i, j] - z[i, j]) ** 2
                dual += form.scale[i] * (rho * (z[i, j] - z_old[i, j])) ** 2
    return primal, dual
