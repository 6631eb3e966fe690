"""Nonsmooth Gauss-Seidel: Coulomb's law solved exactly at one contact after the other.

    repeat   for i = 1..nc:   r_i <- the solution of contact i's law, the others held;   x += R_i (r_i+ - r_i)

Fixed points are exactly the Coulomb solutions. No convergence theorem is known. If a contact's normal and tangential laws were
solved in turn, one sliding contact would converge at the linear rate mu|b|/a, a sticking one at b^2/(a g). Here they are solved
together: one contact takes one sweep. Several converge linearly, slowly for tall stacks and heavy bodies on light ones.

References: Jourdan, Alart and Jean 1998; Jean 1999.
"""

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.problems.compiled import kernel, loop
from frictionbench.problems.packed import Packed
from frictionbench.solvers.interface import Answer, Solved, impulses, solver
from frictionbench.solvers.many import impulses_of, is_alone, solved, unsolved
from frictionbench.solvers.sweeps.form import ContactForm, asked, begin, contact_form, contact_form_of
from frictionbench.solvers.sweeps.gauss_seidel import (
    CHECK,
    LIMIT,
    QUICKLY,
    SLOWLY,
    monitor_sweeps,
    planar_sweeps,
    spatial_sweeps,
)
from frictionbench.solvers.sweeps.laws import residual_at
from frictionbench.solvers.sweeps.stopping import ENDS, Monitor, should_continue


@solver("nsgs", family="splitting", model="coulomb", dimension=(2, 3), warm_start=True)
class NSGS:
    """Nonsmooth Gauss-Seidel: solve each contact's friction law in turn.

    relaxation: factor in (0, 2) on every change of an impulse. precision: double or single.
    Work: sweeps over all contacts, and checks of the residual. History: the residual at the start and after every tenth sweep.
    """

    relaxation: float = 1.0
    precision: str = "double"

    def __post_init__(self) -> None:
        require(0 < self.relaxation < 2, "relaxation", f"must lie between 0 and 2, got {self.relaxation!r}")

    def solve_many(
        self, packed: Packed, tol: float, limit: int | None, start: Array | None = None, pace: tuple[int, float] = SLOWLY
    ) -> Solved:
        if self.precision == "single":  # status None: solved one by one
            return Solved(np.zeros((int(packed.contacts[-1]), packed.dimension)), np.full(packed.size, None), {})
        r, space = impulses(start, (int(packed.contacts[-1]), packed.dimension)), True if packed.dimension == 3 else None
        ended, work = nsgs_loop(packed, r, float(self.relaxation), tol, LIMIT if limit is None else limit, pace, space)
        return solved(r, ended, ENDS, work, ("sweeps", "checks"))

    def form(self, problem: FrictionProblem) -> ContactForm:
        return contact_form(problem, precision=self.precision)

    def solve(self, form: ContactForm, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        return self._sweep(form, start, monitor_sweeps(asked(form, tol), limit))

    def begin(self, form: ContactForm, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        """The step solve as long as it converges QUICKLY."""
        return self._sweep(form, start, monitor_sweeps(asked(form, tol), limit, QUICKLY))

    def _sweep(self, form: ContactForm, start: Array | None, monitor: Monitor) -> Answer:
        r = begin(form, start)
        sweeps = _iterate(form, r, float(self.relaxation), monitor, True if r.shape[1] == 3 else None)
        return monitor.answer(r, sweeps=sweeps, checks=monitor.seen)


@loop
def nsgs_loop(packed, r, relaxation, tol, limit, pace, space):  # type: ignore[no-untyped-def]
    """Overwrite the impulses r of packed problems in turn; return how each ended, and sweeps and checks (N, 2)."""
    _, ended, work = unsolved(packed, 2)
    for k in range(len(ended)):
        if is_alone(packed, k):
            continue
        records = np.empty(2 + limit // CHECK), np.array([np.inf, 0.0]), np.zeros(2, np.int64)
        monitor = Monitor(tol, limit, pace[0], pace[1], records[0], records[1], records[2], np.inf)
        work[k, 0] = _iterate(contact_form_of(packed, k), impulses_of(packed, k, r), relaxation, monitor, space)
        ended[k], work[k, 1] = monitor.state[1], monitor.state[0]
    return ended, work


@kernel
def _iterate(form, r, relaxation, monitor, space):  # type: ignore[no-untyped-def]
    """Overwrite r with the solution; return the number of sweeps. space: None in the plane: only one branch is compiled."""
    x, u = np.empty_like(form.rest), np.empty_like(r)
    sweeps = 0
    while should_continue(monitor, residual_at(form, r, x, u, 1.0), sweeps):
        count = min(CHECK, monitor.limit - sweeps)
        if space is None:
            planar_sweeps(form, r, x, relaxation, count)
        else:
            spatial_sweeps(form, r, x, relaxation, count)
        sweeps += count
    return sweeps
