"""Path search: Newton's method on the normal map, each step a pivotal path, after PATH.

The LCP w = M z + q is the equation F(x+) + x - x+ = 0 of the normal map, with F(z) = M z + q, z = x+ = max(x, 0) and
w = x+ - x. From a point x with residual r = F(x+) + x - x+, the path to the Newton point solves

    M z - w + q = (1 - t) r,     0 <= z ⟂ w >= 0,     t from 0 to 1,

a piecewise linear curve followed by complementary pivots: t enters the basis of x first, and whenever a z_i or w_i leaves,
its complement enters next (Ralph 1994). One Newton step consists of

1. a crash (projected Newton): a few active-set steps guess which z are basic;
2. the path from the crash point, to t = 1 or to where it ends;
3. the Newton point itself, from a fresh LU of the last basis, refined once;
4. acceptance: the residual must fall. Otherwise, or after a path that ends early, the method restarts from z = 0 with another
   perturbation, alternately without and with a crash. (On the problems of the suites no restart is needed.)

Differences from PATH, and their reasons:

* The linearisation of an LCP is exact: where t reaches 1 the Newton point is a solution. A search back along the path could
  only stop short of it, so paths are followed to their end, and a second step is needed only where round-off limits the first.
* The crash point solves a shifted problem: M_AA z_A = -(q_A + delta_A), w_i = max(F_i, 0) + delta_i, with random delta > 0.
  So r < 0, and the existence proof for Lemke's method carries over: a ray v of the path has v >= 0, Mv >= 0, v'Mv = 0, hence
  (1 - t) v'r = v'Mz + v'q, where v'Mz >= 0 if M is copositive, and v'q >= 0 for friction with a bias b >= 0 (Anitescu and
  Potra 1997); but v'r < 0. In trials from crash points with r of either sign, a quarter of the paths on stacks and four in
  ten on random problems ended early; with r < 0 one in a hundred. Being random, delta also resolves exact ties.
* The crash basis must have det M_AA > 0. Along a path t rises with the sign of det B: from a negative sign the path can
  only reach solutions of index -1, of which there is usually one fewer than of index +1, often none. If no basis is found,
  the path starts at z = 0, and is then Lemke's with the covering vector delta (PATH's ray start).
* PATH updates its sparse factors; here they are kept, with one column for each later pivot, up to 96 (solvers.pivots.lu_basis).

References: Dirkse and Ferris, The PATH solver, Optimization Methods and Software 5 (1995); Ralph, Global convergence of
damped Newton's method for nonsmooth equations via the path search, Mathematics of Operations Research 19 (1994).
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.lcp import tangent_basis
from frictionbench.problems.residual import TOL_SHARE
from frictionbench.problems.rows import Index64
from frictionbench.solvers.clock import deadline, is_over
from frictionbench.solvers.interface import Answer, solver
from frictionbench.solvers.pivots.lemke_path import add_matrix_product, is_ray
from frictionbench.solvers.pivots.lu_basis import (
    Columns,
    LUBasis,
    basic_point,
    basic_z,
    factorise_basis,
    new_basis,
    orientation,
    overflowed,
    room,
    set_complementary_basis,
)
from frictionbench.solvers.pivots.newton_path import (
    FACTORISATIONS,
    LIMIT,
    NEWTON,
    RAY,
    RETURNED,
    SINGULAR,
    follow_newton_path,
)
from frictionbench.solvers.pivots.ordering import in_order
from frictionbench.solvers.pivots.scaled_lcp import (
    STATUSES,
    ScaledLCP,
    measured,
    scaled_lcp,
    scaled_residual,
    scaled_rounding,
)
from frictionbench.solvers.pivots.vectors import fill, put

SHIFT = 0.3  # size of the residual at a crash point, relative to the largest scaled q: smaller ones cause near ties on the path
SPREAD = 0.1  # relative randomness of its entries: enough to resolve ties, without making one row the first to block
DEPENDENT_GUESS = 1e-9  # a column of a guessed basis is dependent if elimination leaves less than this share of it
DECREASE = 0.9  # a new residual must be below this share of the last one (Dirkse and Ferris 1995)
RESTART_CRASH = 3  # crash steps of every second restart
WELL = 1 / 16  # below this share of its bound of rounding errors, a residual does not justify a further step

CRASH, STEPS, RESTARTS = 2, 3, 4  # indices of work, after those of pivots and factorisations


@solver("path_search", family="newton", model="lcp", dimension=(2, 3))
class PathSearch:
    """PATH-like normal-map Newton: crash, then a pivotal path to the Newton point, restarted where it stalls.

    crash: active-set steps before the path. restarts: their largest number. facets: of the polygon that approximates the
    cone's section. limit bounds the pivots, by default 50 n + 1000.
    work: pivots, factorisations, crash (steps), newton (steps), restarts.
    """

    crash: int = 3
    restarts: int = 8
    facets: int = 8

    def __post_init__(self) -> None:
        for name in ("crash", "restarts"):
            require(getattr(self, name) >= 0, name, f"must not be negative, got {getattr(self, name)!r}")
        tangent_basis(3, self.facets)  # refuses a wrong number

    def form(self, problem: FrictionProblem | LCP) -> ScaledLCP:
        return scaled_lcp(problem, self.facets)

    def setup(self, scaled: ScaledLCP) -> "Prepared":
        n = len(scaled.q)
        columns, q, unit, order = in_order(scaled.M, scaled.q, scaled.unit, scaled.contacts[0])
        basis, noise = new_basis(n, room(n, len(columns.column))), perturbations(self.restarts + 1, n)
        return Prepared(scaled, order, columns, basis, q, unit, noise)

    def solve(self, prepared: "Prepared", tol: float, limit: int | None, start: Array | None = None) -> Answer:
        scaled, order, columns, basis, q, unit, noise = prepared
        n, target = len(q), TOL_SHARE * tol
        limit = 50 * n + 1000 if limit is None else limit
        settings = q, unit, noise, target, limit, deadline(), self.crash
        z, least, end, ray, work = search(columns, basis, *settings)
        while basis.size[2] > 0 and not is_over():  # the factors did not fit into the storage: repeat with more
            basis = new_basis(n, min(n * n, 4 * len(basis.L.value)))
            z, least, end, ray, work = search(columns, basis, *settings)
        y = np.empty(n)
        y[order] = z
        if least <= target or scaled.residual(y) <= tol:
            end = NEWTON
        elif end not in (LIMIT, SINGULAR):
            end = RAY if ray else RETURNED
        return scaled.answer(y, STATUSES[end], **dict(zip(COUNTS, work.tolist(), strict=True)))


COUNTS = "pivots", "factorisations", "crash", "newton", "restarts"


@lru_cache(maxsize=64)
def perturbations(attempts: int, n: int) -> Array:
    """Random numbers (attempts, n) from [0, 1), the same in every call."""
    return np.random.default_rng(0).random((attempts, n))


class Prepared(NamedTuple):
    """The scaled LCP, its data in an order with little fill, storage for one basis, and the perturbations of all attempts."""

    scaled: ScaledLCP
    order: Index64
    columns: Columns
    basis: LUBasis
    q: Array
    unit: Array
    noise: Array


@kernel
def search(columns, basis, q, unit, noise, tol, limit, until, steps):  # type: ignore[no-untyped-def]
    """Newton's method from z = 0; the best z, its residual, how the last path ended, whether any met a verified ray, work."""
    n = len(q)
    work = np.zeros(5, np.int64)
    z, w, v, A = np.zeros(n), np.empty(n), np.zeros(n), np.zeros(n, np.bool_)
    delta, right, best = np.empty(n), np.empty(n), np.zeros(n)
    put(w, q)
    least = measured(unit, z, w)
    last, end, ray = 1.0, NEWTON, False
    while least > tol:
        shift = SHIFT * min(1.0, max(last, 1e-4))
        for i in range(n):
            delta[i] = shift * (1.0 + SPREAD * noise[work[RESTARTS], i])
            right[i] = q[i] + delta[i]
        crash_point(basis, columns, right, A, z, w, steps, until, work)
        for i in range(n):  # the residual r of the crash point x: -delta on A, elsewhere with w_i = max(F_i, 0) + delta_i
            columns.cover[i] = -delta[i] if A[i] else min(w[i] - delta[i], 0.0) - delta[i]
            right[i] = columns.cover[i] - q[i]
        if not overflowed(basis):
            end = follow_newton_path(basis, columns, right, v, limit, until, work)
        residual = np.inf
        if overflowed(basis):
            break
        if end == NEWTON:
            residual = newton_point(basis, columns, q, unit, v, z, w, until, work)
            if residual < least:
                put(best, z)
                least = residual
            if residual <= WELL * scaled_rounding(columns, q, unit, z, w):
                break
        elif end == RAY:
            ray = ray or is_ray(columns, columns.cover, v, 0.0, w)
        if residual < DECREASE * last:
            last = residual
            basic_z(basis, A)
            continue
        if end == LIMIT or work[RESTARTS] + 1 == len(noise):
            break
        work[RESTARTS] += 1
        last, steps = 1.0, 0 if work[RESTARTS] % 2 else RESTART_CRASH
        fill(z, 0.0)
        fill(A, False)
    return best, least, end, ray, work


@part
def crash_point(basis, columns, q, A, z, w, steps, until, work):  # type: ignore[no-untyped-def]
    """Improve the guess A of the basic z by projected Newton steps, and overwrite z, w with the basic point of LCP(M, q).

    A step exchanges the pairs whose basic variable is negative. Negative z then leave the least infeasible basis until z >= 0.
    Finally z_A >= 0, (Mz + q)_A = 0 and det M_AA > 0; A is empty if this fails.
    """
    n = len(q)
    stored, right = np.empty(n, np.bool_), np.empty(n)
    for i in range(n):
        stored[i], right[i] = A[i], -q[i]
    least = np.inf
    for step in range(steps + 1):
        dependent = complementary(basis, columns, A, until, work)
        basic_point(basis, columns, right, z, w)
        if not dependent:
            infeasible = 0.0
            for i in range(n):
                infeasible -= min(z[i], 0.0) + min(w[i], 0.0)
            if infeasible < least:
                put(stored, A)
                least = infeasible
            if infeasible == 0.0 or step == steps:
                break
        basic_z(basis, A)
        for i in range(n):
            A[i] = z[i] > 0.0 if A[i] else w[i] < 0.0
        work[CRASH] += 1
    put(A, stored)
    for _ in range(4):
        dependent = complementary(basis, columns, A, until, work)
        basic_point(basis, columns, right, z, w)
        basic_z(basis, A)
        below = dependent
        for i in range(n):
            below += not z[i] >= 0.0
        if not below:
            if orientation(basis) > 0:
                return
            break
        for i in range(n):
            A[i] = A[i] and z[i] > 0.0
    fill(A, False)
    complementary(basis, columns, A, until, work)
    fill(z, 0.0)
    put(w, q)


@part
def complementary(basis, columns, A, until, work):  # type: ignore[no-untyped-def]
    """Factorise the complementary basis of A; return the number of columns left out as dependent."""
    set_complementary_basis(basis, A)
    work[FACTORISATIONS] += 1
    return factorise_basis(basis, columns, DEPENDENT_GUESS, until)


@part
def newton_point(basis, columns, q, unit, end, z, w, until, work):  # type: ignore[no-untyped-def]
    """Overwrite z with the Newton point, solved from the basis and refined once, or with the end of the path; its residual.

    The end of the path may be the better of the two if the basis is ill-conditioned, because variables that left the basis
    within the slip of zero are not zero. w is overwritten.
    """
    n = len(q)
    work[STEPS] += 1
    work[FACTORISATIONS] += 1
    factorise_basis(basis, columns, 0.0, until)
    correction, right, point, best = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    put(best, z)
    for i in range(n):
        right[i] = -q[i]
    basic_point(basis, columns, right, z, w)
    for i in range(n):
        right[i], point[i] = w[i] - q[i], -z[i]
    add_matrix_product(columns, point, right)
    basic_point(basis, columns, right, correction, w)
    residual = np.inf
    for refined in (True, False):
        for i in range(n):
            point[i] = max(z[i] + correction[i], 0.0) if refined else max(end[i], 0.0)
        here = scaled_residual(columns, q, unit, point, w)
        if here < residual:
            put(best, point)
            residual = here
    put(z, best)
    return residual
