"""Alternating direction method of multipliers: one copy of the impulses obeys the dynamics, the other stays in the cones.

    (W + rho S) r = rho S z - q - mu |w_t| e_n - w        the dynamics, one sparse factorisation for all iterations
    z+ = P_K(r^ + w/(rho S)),    r^ = alpha r + (1-alpha) z    the cones, contact by contact
    w+ = w + rho S (r^ - z+)                              the multiplier, -(u + mu |u_t| e_n) at the end

with S = diag(s_i) the contacts' scales, in which rho is dimensionless, and over-relaxation alpha. The term mu |w_t| e_n is
de Saxcé's shift: with it the fixed points are Coulomb's solutions (`admm_coulomb`, no convergence theorem), without it those of
the convex relaxation (`admm`, which converges for every fixed rho). rho is multiplied by the root of the ratio of the two
residuals, |r - z| and rho |z+ - z|, which costs a factorisation each time; the iterations must double in between, so that rho
converges.

References: Boyd, Parikh, Chu, Peleato and Eckstein 2011, sections 3.3 and 3.4; Tasora, Mangoni, Benatti and Garziera 2021;
Carpentier, Le Lidec and Montaut 2024.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.rows import Index32
from frictionbench.solvers.interface import Answer, impulses, solver
from frictionbench.solvers.sweeps.form import ContactForm, contact_form
from frictionbench.solvers.sweeps.laws import residual_at
from frictionbench.solvers.sweeps.projected_gradient import step
from frictionbench.solvers.sweeps.stopping import monitor, should_continue

LIMIT = 10_000  # iterations by default, as many as sweeps of nsgs
PATIENCE = 2500  # iterations in which the residual must fall by a hundredth: a quarter of the limit
CHECK = 10  # iterations between two residuals, whose cost is then a tenth of an iteration's
ALPHA = 1.6  # over-relaxation: 1.5 to 1.8 is recommended (Boyd et al. 2011, section 3.4.3)
RHO = 0.1  # initial penalty, relative to the scales S; adapted afterwards, as OSQP does from the same value
RETUNE = 2.0  # least factor of rho that is worth a factorisation


class Factor(NamedTuple):
    """P_r A P_c = L U of a sparse matrix; L and U by columns (start, row, entry), L's diagonal 1 and U's stored separately."""

    row: Index32
    column: Index32
    L: tuple[Index32, Index32, Array]
    U: tuple[Index32, Index32, Array]
    diagonal: Array


@dataclass(frozen=True, eq=False)
class Formed:
    """The packed problem; W, its contacts' scales S (nc*d,) and q (nc, d)."""

    form: ContactForm
    W: sparse.csc_array
    S: Array
    q: Array


@solver("admm", family="splitting", model="relaxation", dimension=(2, 3), warm_start=True, sparse=True)
class ADMM:
    """Alternating direction method of multipliers on the convex relaxation's dual.

    Work: iterations, factorisations, that of the setup among them, and checks of the residual. History: the relaxation's
    residual every tenth iteration.
    """

    shift = 0.0

    def form(self, problem: FrictionProblem) -> Formed:
        W, S = sparse.csc_array(problem.W), np.repeat(problem.scale, problem.dimension)
        return Formed(contact_form(problem), W, S, problem.q.reshape(-1, problem.dimension))

    def setup(self, formed: Formed) -> tuple[Formed, Factor]:
        return formed, _factorise(formed.W, RHO * formed.S)

    def solve(self, prepared: tuple[Formed, Factor], tol: float, limit: int | None, start: Array | None = None) -> Answer:
        formed, factor = prepared
        form, rho = formed.form, RHO
        z, monitored = impulses(start, form.offset.shape), monitor(tol, LIMIT if limit is None else limit, PATIENCE, CHECK)
        x, u, w = np.empty_like(form.rest), np.empty_like(z), np.empty_like(z)
        iterations, factorisations, retune = 0, 1, 0
        while should_continue(monitored, residual_at(form, z, x, u, self.shift), iterations):
            if iterations == 0:
                w[:] = -u
                w[:, 0] -= self.shift * form.friction * np.linalg.norm(u[:, 1:], axis=1)
            count = min(CHECK, monitored.limit - iterations)
            primal, dual = _alternate(form, factor, formed.q, rho, self.shift, z, w, count)
            iterations += count
            ratio = (primal / dual) ** 0.25 if primal > 0 and dual > 0 else 1.0
            if iterations >= retune and not 1 / RETUNE < ratio < RETUNE:
                retune = 2 * iterations
                rho = float(np.clip(rho * ratio, 1e-6, 1e6))
                factor = _factorise(formed.W, rho * formed.S)
                factorisations += 1
        return monitored.answer(z, iterations=iterations, factorisations=factorisations, checks=monitored.seen)


@solver("admm_coulomb", family="splitting", model="coulomb", dimension=(2, 3), warm_start=True, sparse=True)
class ADMMCoulomb(ADMM):
    """Alternating direction method of multipliers with de Saxcé's shift.

    Work: iterations, factorisations, that of the setup among them, and checks of the residual. History: the residual every
    tenth iteration.
    """

    shift = 1.0


def _factorise(W: sparse.csc_array, diagonal: Array) -> Factor:
    """Sparse factors of W + diag(diagonal)."""
    if not len(diagonal):
        nothing = (np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros(0))
        return Factor(nothing[1], nothing[1], nothing, nothing, nothing[2])
    A = sparse.csc_matrix(W + sparse.diags_array(diagonal))
    lu = splu(A, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    strict = (sparse.tril(lu.L, -1, format="csc"), sparse.triu(lu.U, 1, format="csc"))
    L, U = ((part.indptr.astype(np.int32), part.indices.astype(np.int32), part.data) for part in strict)
    return Factor(lu.perm_r.astype(np.int32), lu.perm_c.astype(np.int32), L, U, lu.U.diagonal())


@part
def _solve(factor, b, y):  # type: ignore[no-untyped-def]
    """Overwrite b by A^-1 b; y is scratch."""
    n = len(b)
    start, row, entry = factor.L
    for i in range(n):
        y[factor.row[i]] = b[i]
    for j in range(n):
        for k in range(start[j], start[j + 1]):
            y[row[k]] -= entry[k] * y[j]
    start, row, entry = factor.U
    for j in range(n - 1, -1, -1):
        y[j] /= factor.diagonal[j]
        for k in range(start[j], start[j + 1]):
            y[row[k]] -= entry[k] * y[j]
    for i in range(n):
        b[i] = y[factor.column[i]]


@kernel
def _alternate(form, factor, q, rho, shift, z, w, count):  # type: ignore[no-untyped-def]
    """`count` iterations on z and w (nc, d). Returns the primal and the dual residual of the last, squared."""
    nc, d = z.shape
    r, z_old, y = np.empty_like(z), np.empty_like(z), np.empty(nc * d)
    primal, dual = 0.0, 0.0
    for _ in range(count):
        for i in range(nc):
            slide = 0.0
            for j in range(d):
                slide += w[i, j] ** 2 if j else 0.0
                r[i, j] = rho * form.scale[i] * z[i, j] - q[i, j] - w[i, j]
            r[i, 0] -= shift * form.friction[i] * np.sqrt(slide)
        _solve(factor, r.reshape(nc * d), y)
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
