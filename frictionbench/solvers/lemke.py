"""Lemke's method for the LCP, with scaling, perturbation, refinement and restarts.

    w = M z + q + d z0,   w, z >= 0,   w'z = 0,   d > 0.

For z0 large enough, z = 0 is a solution; Lemke's method follows the path of solutions that starts there. On the path exactly
one pair has both members nonbasic, and the member that did not just leave the basis enters next. The path ends at z0 = 0, a
solution of the LCP, or on a secondary ray. For a friction step with b >= 0 there is no secondary ray, so Lemke's method solves
it (Anitescu and Potra 1997). References: Lemke 1965; Murty 1988, chapter 2; Cottle, Pang and Stone 1992, section 4.4.

In floating point the method is implemented as follows.

* The problem is scaled (solvers.pivots.scaled_lcp), so that tolerances are dimensionless. Pivoting uses the inverse of the
  active part of the basis, with iterative refinement against M. The inverse is recomputed when it becomes inaccurate. Small
  problems are first pivoted on a dense tableau (solvers.pivots.tableau), whose last basis is refined and checked likewise.
* Ties: q is perturbed along a vector with random positive entries, which makes every basis nondegenerate with probability
  one, and a path through nondegenerate bases cannot return to one of them. Near ties are resolved in favour of the largest
  pivot (Harris 1973). The last basis is solved for the unperturbed q. If negative entries leave a residual above round-off,
  the method continues from this basis with a smaller perturbation and with d expressed in the coordinates of this basis.
* A solution is claimed only after its residual has been computed, a secondary ray only after its certificate has been
  checked. Otherwise, and also after a ray, the method restarts with other covering vectors from a fixed sequence. After a ray
  this may not help: for a bimatrix game every d leads to a ray at once, although solutions exist. On a bare LCP
  lemke[restarts=0] is the textbook method, with d = 1 in scaled units.
* A heavy body on a light one makes M nearly singular. At a mass ratio of 1e10, z0 falls by 1e-10 where impulses rise by 1, and
  basic variables carry the rounding errors of impulses 1e10 times as large as q. Restarts therefore refine every column to
  full accuracy, so that such small pivots can be used, recompute the basic variables after every pivot, and perturb q by more
  than their rounding errors. A residual that rounding alone explains is accepted.

A warm start (impulses) is converted to a guess of the basis. If this basis is invertible, the path starts from it, as it does
after the perturbation has been reduced. If it is singular, or that path fails, the method starts from z = 0.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.problems.compiled import inlined, kernel, lean, lean_loop
from frictionbench.problems.forms.islands import EPSILON
from frictionbench.problems.forms.lcp import tangent_basis
from frictionbench.problems.packed import CONTACT, Packed
from frictionbench.problems.residual import TOL_SHARE, residual_floor
from frictionbench.problems.rows import Index64
from frictionbench.solvers.clock import deadline, is_past, late
from frictionbench.solvers.interface import Answer, Solved, Status, impulses, solver
from frictionbench.solvers.many import ALONE, impulses_of, is_alone, solved, unsolved
from frictionbench.solvers.pivots.inverse_basis import Matrix, invert, make_slack, refactor
from frictionbench.solvers.pivots.lemke_path import (
    ACCURACY,
    CERTIFICATE,
    COMPLEMENTARY,
    FULL,
    HARRIS,
    INACCURATE,
    LIMIT,
    PERTURBATION,
    RAY,
    USUAL,
    LemkeState,
    add_coordinates,
    basic_values,
    draw,
    first_unknowns,
    follow_lemke_path,
    is_ray,
    lemke_state,
)
from frictionbench.solvers.pivots.packed_lcp import lcp_space, scaled_lcp_of, write_stretched
from frictionbench.solvers.pivots.scaled_lcp import (
    STATUSES,
    ScaledLCP,
    finish,
    scaled_lcp,
    scaled_residual,
    scaled_rounding,
)
from frictionbench.solvers.pivots.tableau import SMALL, Tableau, follow_in_tableau, new_tableau, store
from frictionbench.solvers.pivots.vectors import fill, largest, least, put

RESTARTS = 8  # the largest number of further covering vectors by default
CLEAN = 1e-14  # largest residual at which a solution from the tableau is not refined
ROUND_OFF = 1e-12  # residual at the level of round-off, below which no smaller perturbation is tried
NO_BASIS = np.empty(0, np.int64)  # no guess of the basis
NEGLIGIBLE = 1e-9  # impulses of a start below this share of the largest count as zero
ROUGH = 1e-3  # the largest residual accepted as rounding: where rounding causes more, impulses are far too large
BASIC_ROUNDING = 1e3 * EPSILON  # rounding error of basic variables, relative to the largest; perturbations must exceed it
COARSEST = 1e-3  # the largest perturbation


class LemkeProblem(NamedTuple):
    """The scaled LCP w = M y + q with its unit (ScaledLCP), its number of contacts, and the indices of the basic z of a guess.

    contacts: 0 for a bare LCP. copositive: whether M is known to be copositive, as in every friction LCP.
    """

    M: Matrix
    q: Array
    unit: Array
    contacts: int
    guess: Index64
    copositive: bool


class Limits(NamedTuple):
    """The residual to reach, the largest number of pivots, 0 for 100 000 + 100 n, that of restarts, and the deadline."""

    tol: float
    pivots: int
    restarts: int
    until: float


class Memory(NamedTuple):
    """Workspace for problems of up to n unknowns: the state of the path, the dense tableau, the best y, and the random numbers
    (n,) that perturb q in the first trial."""

    state: LemkeState
    tableau: Tableau
    best: Array
    noise: Array


@kernel
def memory(M: Matrix, n: int) -> Memory:
    """Workspace for problems of up to n unknowns whose matrix is M, or is stored in the arrays of M."""
    noise = np.empty(n)
    draw(1, noise)  # a shorter vector would receive the first of these numbers
    return Memory(lemke_state(M, n), new_tableau(n), np.empty(n), noise)


@kernel
def lemke(M, q, unit, contacts, guess, copositive, tol, pivots, restarts, until):  # type: ignore[no-untyped-def]
    """lemke_within with new workspace, and the solution. No tuples: each adds to the time of calling a kernel from Python."""
    storage = memory(M, len(q))
    problem, limits = LemkeProblem(M, q, unit, contacts, guess, copositive), Limits(tol, pivots, restarts, until)
    return *lemke_within(storage, problem, limits), storage.best


@lean
def lemke_within(memory: Memory, problem: LemkeProblem, limits: Limits) -> tuple[int, int, int, int]:
    """Start from the guess, then from z = 0, then with other covering vectors, until the residual is small enough.

    Returns (how it ended, pivots, restarts, inversions); the best solution is written to memory.best.
    """
    (M, q, unit, _, guess, copositive), (tol, most, restarts, until), n = problem, limits, len(problem.q)
    state, best_y, most = first_unknowns(memory.state, n), memory.best[:n], most if most else 100_000 + 100 * n
    basis, x, work = state.basis, state.x, state.work
    work[0] = work[1] = 0
    fill(best_y, 0.0)
    fill(basis.d, 1.0)
    best = scaled_residual(M, q, unit, best_y, state.v)
    ended = COMPLEMENTARY if best <= tol else INACCURATE
    trial = first = -1 if len(guess) else 0
    goal, reach = tol, 0.0  # the residual to reach; the largest basic variable so far
    while best > goal and work[0] < most and trial <= restarts and not late(until):
        size, precision = PERTURBATION, USUAL
        if trial > 0:
            size, precision = max(PERTURBATION, min(BASIC_ROUNDING * reach, COARSEST)), FULL
        make_slack(basis)
        work[1] += trial < 0
        going = trial >= 0 or invert(basis, guess)
        cold = basis.size[0] == 0
        # Most paths take at most about 3 n pivots, Murty's examples many more: only the last trial has no bound of its own.
        budget = most if trial == restarts else min(most, work[0] + 5 * n + 1000)
        while going:
            perturb(memory, state, problem, trial, size)
            code, rough = follow(memory, state, problem, cold and trial == 0, HARRIS * size, precision, budget, until)
            if not rough:
                reach = max(reach, largest(x, n))
            if code == RAY and cold and certified(state, q, copositive):
                ended = RAY
            elif work[0] >= most or late(until):
                ended = LIMIT
            if code != COMPLEMENTARY:
                break
            error = refined(memory, state, problem, tol) if rough else finish(state, q, unit)
            reach = max(reach, largest(x, n))
            rounding = 0.0 if error <= min(tol, ROUND_OFF) else min(scaled_rounding(M, q, unit, state.y, state.v), ROUGH)
            if error < best:
                best, goal = error, max(tol, rounding)
                put(best_y, state.y)
            going = size >= 1e-12 and error > max(min(tol, ROUND_OFF), rounding) and not least(x, n) >= -4e-16 * largest(x, n)
            size, cold = size * 1e-2, False
        if best <= goal:
            ended = COMPLEMENTARY if best <= tol else ALONE  # rounding explains it: `solve` checks the impulses
        trial += 1
    return ended, work[0], max(trial - 1 - first, 0), work[1]


@inlined
def perturb(memory: Memory, state: LemkeState, problem: LemkeProblem, trial: int, size: float) -> None:
    """Overwrite d with the trial's covering vector and state.q with q plus a perturbation, in the coordinates of the basis."""
    basis, drawn = state.basis, state.v
    if trial > 0:
        draw(2 * trial, drawn)
    else:
        first_cover(drawn, problem.contacts)
    fill(basis.d, 0.0)
    add_coordinates(basis, drawn, 1.0, basis.d)
    put(drawn, memory.noise)
    if trial:
        draw(2 * trial + 1, drawn)
    for i in range(len(drawn)):
        drawn[i] += 9.0  # entries from [1, 1.1) after division by 10: nearly uniform perturbations lead to shorter paths
    put(state.q, problem.q)
    add_coordinates(basis, drawn, size / 10.0, state.q)


@inlined
def follow(
    memory: Memory,
    state: LemkeState,
    problem: LemkeProblem,
    first: bool,
    slack: float,
    precision: tuple[float, float],
    budget: int,
    until: float,
) -> tuple[int, bool]:
    """How the path ended, and whether on the tableau, which is tried for the first path of a small problem."""
    if first and len(problem.q) <= SMALL:
        put(state.v, problem.q)
        code = follow_in_tableau(state, memory.tableau, slack, budget)
        if code != INACCURATE:
            return code, True
    basic_values(state.basis, state.q, state.x, ACCURACY)
    return follow_lemke_path(state, slack, precision, budget, until), False


@inlined
def refined(memory: Memory, state: LemkeState, problem: LemkeProblem, tol: float) -> float:
    """The residual of the tableau's solution. Above CLEAN, the last basis is solved again, if necessary with a new inverse."""
    q, unit, basis = problem.q, problem.unit, state.basis
    error = scaled_residual(basis.M, q, unit, state.y, state.v)
    if error > min(tol, CLEAN):
        store(memory.tableau, basis)
        error = finish(state, q, unit)
    if error > tol:
        state.work[1] += 1
        if refactor(basis):
            error = finish(state, q, unit)
    return error


@lean
def certified(state: LemkeState, q: Array, copositive: bool) -> bool:
    """Whether (v, v0) = a is a secondary ray. If M is copositive, this implies v0 = 0 and q'v < 0, which is checked as well."""
    v, v0, n, along = state.a, state.a[len(q)], len(q), 0.0
    for i in range(n):
        along += q[i] * v[i]
    slack = CERTIFICATE * largest(v, n)
    return (not copositive or v0 <= slack < -along) and is_ray(state.basis.M, state.basis.d, v[:n], v0, state.v)


@lean_loop
def lemke_loop(packed, basis, guess, first, limits, lcp, memory, r, ended, work):  # type: ignore[no-untyped-def]
    """Solve packed problems in turn. Overwrites the impulses r, how each ended, and pivots, restarts and inversions (N, 3).

    guess: the indices of the basic z; those of problem k are guess[first[k]:first[k + 1]].
    """
    for k in range(len(ended)):
        if is_alone(packed, k):
            continue
        fits, stretch, M, q, unit = scaled_lcp_of(packed, k, basis, lcp)
        if not fits:
            continue
        impulse = impulses_of(packed, k, r)
        problem = LemkeProblem(M, q, unit, len(impulse), guess[first[k] : first[k + 1]], True)
        ended[k], work[k, 0], work[k, 1], work[k, 2] = lemke_within(memory, problem, limits)
        write_stretched(basis, memory.best[: len(q)], stretch, impulse)


@solver("lemke", family="pivoting", model="lcp", dimension=(2, 3), warm_start=True)
class Lemke:
    """Lemke's complementary pivoting, scaled, perturbed, refined and checked. (Lemke 1965)

    restarts: the largest number of further covering vectors. facets: of the polygon that approximates the cone's section.
    limit bounds the pivots, by default 100 000 + 100 n.
    """

    restarts: int = RESTARTS
    facets: int = 8
    dense_matrices = 2  # the inverse of the basis, old and new

    def __post_init__(self) -> None:
        require(self.restarts >= 0, "restarts", f"must not be negative, got {self.restarts!r}")
        tangent_basis(3, self.facets)  # refuses a wrong number

    def form(self, problem: FrictionProblem | LCP) -> ScaledLCP:
        return scaled_lcp(problem, self.facets)

    def solve(self, scaled: ScaledLCP, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        guess, problem = NO_BASIS, scaled.problem
        if start is not None and isinstance(problem, FrictionProblem):
            one, law = np.array([0, problem.contacts]), (problem.friction, problem.friction_bias)
            guess, _ = guess_bases(one, impulses(start, scaled.contacts), *law, tangent_basis(problem.dimension, self.facets))
        if is_past(deadline(2.0 * len(guess) ** 3)):  # inverting the guess would take too long; start from z = 0 instead
            guess = NO_BASIS
        limits = TOL_SHARE * tol, limit or 0, self.restarts, deadline()
        arguments = scaled.M, scaled.q, scaled.unit, scaled.contacts[0], guess, scaled.basis is not None
        ended, pivots, restarts, inversions, y = lemke(*arguments, *limits)
        answer = scaled.answer(y, STATUSES[ended], pivots=pivots, restarts=restarts, inversions=inversions)
        if ended == ALONE:  # rounding of the LCP is larger than that of the impulses, for example where a contact opens
            floor = residual_floor(problem, answer.impulse) if isinstance(problem, FrictionProblem) else 0.0
            answer.status = Status.SOLVED if scaled.residual(y) <= max(tol, floor) else Status.BREAKDOWN
        return answer

    def solve_many(self, packed: Packed, tol: float, limit: int | None, start: Array | None = None) -> Solved:
        basis = tangent_basis(packed.dimension, self.facets)
        guess = NO_BASIS, np.zeros(packed.size + 1, np.int64)
        if start is not None:
            contacts = slice(packed.first[0, CONTACT], packed.first[-1, CONTACT])
            guess = guess_bases(packed.contacts, start, packed.friction[contacts], packed.friction_bias[contacts], basis)
        r, ended, work = unsolved(packed, 3)
        limits = Limits(TOL_SHARE * tol, limit or 0, self.restarts, np.inf)
        lcp, n = lcp_space(packed, basis), int(np.diff(packed.contacts).max(initial=0)) * (len(basis[0]) + 1)
        lemke_loop(packed, basis, *guess, limits, lcp, memory(lcp.matrix, n), r, ended, work)
        return solved(r, ended, STATUSES, work, ("pivots", "restarts", "inversions"))


@lean
def first_cover(d: Array, contacts: int) -> None:
    """d = 1 in scaled units, and 30 in the tangential rows of a friction LCP. Any d > 0 is admissible; with this one, normal
    impulses enter the basis before tangential ones, which saved a third of the pivots in measurements."""
    fill(d, 1.0)
    for i in range(contacts, len(d) - contacts if contacts else 0):
        d[i] = 30.0


def guess_bases(first: Index64, impulse: Array, mu: Array, wider: Array, basis: Array) -> tuple[Index64, Index64]:
    """Guess which z are basic from contact impulses (basic_by_contact), for N problems whose contacts begin at first (N+1,).

    Returns their indices, problem by problem, and where those of each problem begin (N+1,).
    """
    count, nc, width = len(first) - 1, np.diff(first), len(basis[0]) + 1
    problem, size = np.repeat(np.arange(count), nc), np.zeros(count)
    np.maximum.at(size, problem, np.abs(impulse).max(axis=1))
    contact, unknown = np.nonzero(basic_by_contact(impulse, mu, wider, basis, NEGLIGIBLE * size[problem]))
    problem = problem[contact]
    i, n = contact - first[problem], nc[problem]
    index = np.where(unknown == 0, i, np.where(unknown < width - 1, n + i * (width - 2) + unknown - 1, n * (width - 1) + i))
    ordered = np.lexsort((index, problem))
    return index[ordered], np.searchsorted(problem, np.arange(count + 1))


def basic_by_contact(impulse: Array, mu: Array, wider: Array, basis: Array, least: Array) -> NDArray[np.bool_]:
    """Guess from the impulses which unknowns c, beta (K) and lambda of each contact are basic (nc, K + 2).

    c and beta are basic if their impulse exceeds `least` (nc,), lambda if the contact slides. wider: the friction bias b_f.
    """
    r_t, directions = impulse[:, 1:], basis[1:, 1:].T
    along = np.einsum("ia,ka->ik", r_t, directions)
    nearest = np.argsort(-along, axis=1, kind="stable")[:, : len(basis) - 1]
    part = np.linalg.solve(np.swapaxes(directions[nearest], 1, 2), r_t[:, :, None])[:, :, 0]
    beta = np.zeros(along.shape)
    np.put_along_axis(beta, nearest, part, axis=1)
    sliding = beta.sum(axis=1) >= (1 - 1e-6) * (mu * impulse[:, 0] + wider)
    sliding &= beta.max(axis=1) > least
    return np.column_stack([impulse[:, 0] > least, beta > least[:, None], sliding])
