"""Interior point methods for Coulomb friction itself, sparse in the velocities of the bodies.

In the plane the problem is the friction LCP; in space it keeps the circular cone (solvers.interior.point). A step costs one
sparse factorisation of the size of the mass matrix (solvers.interior.newton, solvers.sparse_lu.multifrontal), as for the convex
relaxation. Mehrotra's predictor-corrector (solvers.interior.predictor_corrector) comes first: about ten iterations, little more
for a thousand boxes than for ten.

The problem is not monotone, and the predictor-corrector can be trapped: in a few of a hundred random instances, and in large
piles with much friction. In space, and in the plane from LARGE contacts on, the convex relaxation is then solved, which is
monotone. If its solution nearly obeys Coulomb's law, as it does when nothing slides, the predictor-corrector starts from it, as
it does later from the result of Gauss-Seidel. In the plane, from LARGE contacts on, semismooth Newton
(solvers.interior.fischer_burmeister) is next: it follows no path, and solves most large random contact graphs and piles of
discs. Finally the central path is followed around its folds (solvers.interior.central_path) from one start after the other:
some are the same for all problems, others are centred points (solvers.interior.point) around the result of Gauss-Seidel, the
relaxation's solution or given impulses. No start has the shortest path in all problems. Therefore all first receive a short
share of the work, then a few receive a long one.

* In space, for many contacts with much friction, paths are several times shorter if the products of friction are larger than
  the normal ones at the start, so that sliding and sticking are decided after opening and closing.
* If light bodies carry heavy ones, the first paths start with about the same impulse at all contacts, that of the heaviest:
  impulses that stop a contact's own velocity are far too small.
* A part of the problem in which the predictor-corrector is trapped shortens the steps of all others. Separate parts are then
  solved one by one, unless one of them is nearly the whole problem.
* With a warm start, the predictor-corrector starts at the centred point around the given impulses, whose distance from the
  boundary is their residual: a bad start does little harm.
"""

from collections import Counter
from collections.abc import Iterator
from functools import cache
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.packed import Packed, residuals
from frictionbench.problems.residual import contact_residuals, residual
from frictionbench.problems.subproblems import separate
from frictionbench.solvers.clock import is_over
from frictionbench.solvers.interface import Answer, Solved, Status, impulses, solve, solver
from frictionbench.solvers.interior.central_path import Path, new_path, trace
from frictionbench.solvers.interior.fischer_burmeister import fischer_burmeister
from frictionbench.solvers.interior.phases import NO_DISTANCE, Phase, Phased, Prepared, first_phase, first_point, run
from frictionbench.solvers.interior.point import Point, centred_point, start_point
from frictionbench.solvers.interior.predictor_corrector import predictor_corrector
from frictionbench.solvers.interior.system import System, space_of

# All were tuned by the numbers of solved problems and of factorisations with a start left out or a limit changed. Impulses and
# speeds are relative to a contact's own.
# In the plane the relaxation and semismooth Newton come before paths from so many contacts on. In smaller problems paths are as
# short, and if there are several solutions, paths find neighbouring ones in neighbouring problems.
LARGE = 40
NEWTON_STARTS = ((0.1, 1.0), (1.0, 1.0))  # of semismooth Newton in the plane: (impulse, speed)
PLANAR_STARTS = ((0.1, 10.0), (1.0, 10.0), (0.1, 100.0), (1.0, 100.0), (10.0, 1.0), (1.0, 1.0))  # (impulse, speed)
FIRST_START, LAST_START = (1.0, 10.0, 10.0), (1.5, 5.0, 1.0)  # in space: (impulse, speed, factor on the friction's products)
UNLIKE, LOAD_STARTS = 10.0, (0.75, 1.0)  # in space: the ratio of contacts' masses above which paths start loaded; exponents
# Starts around results of Gauss-Seidel and the relaxation: (least distance from the boundary, factor on friction's products).
SWEPT_START = (1.0, 10.0)
RELAXED_STARTS = ((3.0, 10.0), (3.0, 3.0), (1.0, 10.0), (3.0, 30.0))  # the swept path is continued after the first of these
SWEEPS = 1000  # of nsgs, whose result is a start: they take the time of ten or twenty factorisations
LEAST_DISTANCE = 1e-10  # of a start of the predictor-corrector from the boundary, as a residual: less is lost in rounding
PATH_DISTANCE, LONG_DISTANCES = 0.3, (3.0, 10.0)  # the same for paths in the plane, which are shorter from well inside
NEARLY_SOLVED = 0.01  # the largest residual of another method's impulses from which the predictor-corrector is tried
GIANT = 0.9  # share of contacts in one part above which parts are not solved separately: it would take as long as the whole
LIMIT = 16000  # factorisations in all: enough for the shares of all starts in problems of a few hundred contacts
NEWTON_SHARE = 100  # factorisations of one run of semismooth Newton: 95 % of the runs that converge within 150 take fewer
PHASE_SHARE = 250  # factorisations of each phase other than long paths: in the plane few that converge take more
# Factorisations of long paths, in multiples of the contacts or, if larger, of 2 PHASE_SHARE. In space every round adds PATH.
PATH, SHORT_PATH, LOADED_PATH = 3, 0.4, 2
POLISHING = 60  # factorisations of Newton's methods near a solution: a vanishing pair stops a path at a residual of 1e-7
PATIENCE = 12  # iterations of the predictor-corrector without progress: no run that recovered took more


@solver(
    "interior_point",
    family="interior point",
    model="coulomb",
    dimension=(2, 3),
    warm_start=True,
    members=("nsgs", "relaxation_ip", "proximal_newton"),
)
class InteriorPoint(Phased):
    """Predictor-corrector on Coulomb's law, then its central path; one sparse factorisation an iteration.

    If it is trapped it becomes a portfolio: paths start around the results of nsgs and relaxation_ip, and proximal_newton
    refines points that are nearly solutions; their work is counted under their names.
    """

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        """limit bounds the factorisations."""
        problem, system = prepared
        spent: Counter[str] = Counter()

        def polish(impulse: Array) -> Array:
            if problem.dimension == 3:
                return _nested(problem, "proximal_newton", spent, tol=tol, limit=POLISHING, start=impulse)
            newton = fischer_burmeister, _around(problem, system, impulse, LEAST_DISTANCE), POLISHING
            refined = run(prepared, [newton], tol, POLISHING, PATIENCE, residual)
            spent.update(_named("polishing", refined))
            return refined.impulse

        phases, most = self._phases(*prepared, start, spent), LIMIT if limit is None else limit
        polishable = problem.dimension == 3 or problem.contacts >= LARGE
        answer = run(prepared, phases, tol, most, PATIENCE, residual, polish if polishable else None)
        answer.work |= spent
        if answer.status in (Status.STALLED, Status.BREAKDOWN) and _has_parts(problem):
            return self._solve_parts(problem, answer, tol, limit, start)
        return answer

    def begin(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        """The step solve with the predictor-corrector only, around the given impulses and from a start of its own."""
        phases = islice(self._phases(*prepared, start, Counter()), 1 if start is None else 2)
        return run(prepared, phases, tol, LIMIT if limit is None else limit, PATIENCE, residual)

    def solve_many(self, packed: Packed, tol: float, limit: int | None, start: Array | None = None) -> Solved:
        """The first phase in a compiled loop; problems that it does not solve are left to be solved one by one."""
        guess = impulses(start, (int(packed.contacts[-1]), packed.dimension))
        return first_phase_of(packed, tol, limit, guess, np.full(packed.size, start is not None))

    def _solve_parts(
        self, problem: FrictionProblem, whole: Answer, tol: float, limit: int | None, start: Array | None
    ) -> Answer:
        """Solve each part that is not solved by the answer to the whole problem; keep the impulses with the smaller residual.

        The status is that of the first part that is not solved. work: the sum over the whole problem and the parts;
        history: that of the whole problem, then those of the parts.
        """
        impulse, work, history = whole.impulse.copy(), Counter(whole.work), whole.history
        by_contact, unsolved = contact_residuals(problem, impulse), None
        for contacts, part in separate(problem):
            had = by_contact[contacts].max()
            if had <= tol:
                continue
            if is_over():
                unsolved = unsolved or Status.TIME_LIMIT
                break
            answer = self.solve(self.setup(self.form(part)), tol, limit, None if start is None else start[contacts])
            work.update(answer.work)
            history += answer.history
            if answer.status is not Status.SOLVED:
                unsolved = unsolved or answer.status
            if not had <= residual(part, answer.impulse):
                impulse[contacts] = answer.impulse
        return Answer(impulse, unsolved or Status.SOLVED, dict(work), history)

    def _phases(self, problem: FrictionProblem, system: System, start: Array | None, spent: Counter[str]) -> Iterator[Phase]:
        """The methods in turn, with their starting points; only the first if the problem has parts. spent: see _nested."""
        if start is not None:
            guess = impulses(start, system.offset.shape)
            yield predictor_corrector, _around(problem, system, guess, LEAST_DISTANCE), PHASE_SHARE
        trapped = first_point(system)
        yield predictor_corrector, trapped, PHASE_SHARE
        if _has_parts(problem):
            return

        @cache
        def relaxed() -> Array:
            return _nested(problem, "relaxation_ip", spent)

        space, large = problem.dimension == 3, problem.contacts >= LARGE
        if space or large:
            yield from _near(problem, system, relaxed())
        if space:
            yield from self._spatial(problem, system, relaxed(), start, spent)
            return
        if large:
            for impulse, speed in NEWTON_STARTS:
                yield fischer_burmeister, start_point(system, impulse, speed), NEWTON_SHARE
            yield fischer_burmeister, trapped, NEWTON_SHARE
        swept = _guess(problem, start, spent)
        yield from _near(problem, system, swept)
        yield trace, new_path(_around(problem, system, swept, PATH_DISTANCE)), PHASE_SHARE
        for impulse, speed in PLANAR_STARTS:
            yield trace, new_path(start_point(system, impulse, speed)), PHASE_SHARE
        share = PATH * max(2 * PHASE_SHARE, problem.contacts)
        for distance in LONG_DISTANCES:
            yield trace, new_path(_around(problem, system, swept, distance)), share
        yield trace, new_path(_around(problem, system, relaxed(), LONG_DISTANCES[-1])), share

    def _spatial(
        self, problem: FrictionProblem, system: System, relaxed: Array, start: Array | None, spent: Counter[str]
    ) -> Iterator[Phase]:
        """Paths in space; relaxed: the impulses of the relaxation's solution."""
        share = max(2 * PHASE_SHARE, problem.contacts)
        loaded = []
        if system.weight.max(initial=0) > UNLIKE * system.weight.min(initial=np.inf):
            loaded = [new_path(_loaded(system, exponent)) for exponent in LOAD_STARTS]
        for path in loaded:
            yield trace, path, LOADED_PATH * share

        def around(impulse: Array, distance: float, wide: float) -> Path:
            return new_path(_widened(_around(problem, system, impulse, distance), wide))

        first, last = (new_path(_generic(system, *each)) for each in (FIRST_START, LAST_START))
        yield trace, first, int(SHORT_PATH * share)
        guess = _guess(problem, start, spent)
        yield from _near(problem, system, guess)
        swept = around(guess, *SWEPT_START)
        yield trace, swept, int(SHORT_PATH * share)
        nearest, *others = (around(relaxed, *each) for each in RELAXED_STARTS)
        paths = [*loaded, nearest, swept, *others, first, last]
        while paths := [path for path in paths if not path.ended]:
            for path in paths:
                yield trace, path, PATH * share


def _has_parts(problem: FrictionProblem) -> bool:
    """Whether the problem has parts that are solved one by one if the whole is not solved at once."""
    return bool(np.bincount(problem.parts[: problem.contacts]).max(initial=0) < GIANT * problem.contacts)


def first_phase_of(packed: Packed, tol: float, limit: int | None, guess: Array, guessed: NDArray[np.bool_]) -> Solved:
    """The first phase of packed problems, started around the impulses guess (contacts, d) of those that are guessed (N,)."""
    distance = np.full(packed.size, NO_DISTANCE)
    if guessed.any():
        distance[guessed] = np.maximum(residuals(packed, guess)[guessed, 0], LEAST_DISTANCE)
    return first_phase(packed, guess, distance, tol, PHASE_SHARE if limit is None else min(PHASE_SHARE, limit), PATIENCE)


def _nested(problem: FrictionProblem, spec: str, spent: Counter[str], **options: Any) -> Array:
    """The impulses (nc, d) that another solver finds; its work is added to spent, under its name."""
    answer = solve(problem, spec, **options)
    spent.update(_named(spec, answer))
    return answer.impulse


def _named(name: str, answer: Answer) -> dict[str, int]:
    return {f"{name} {unit}": count for unit, count in answer.work.items()}


def _guess(problem: FrictionProblem, start: Array | None, spent: Counter[str]) -> Array:
    """The impulses (nc, d) that Gauss-Seidel finds, or the given ones if their residual is smaller."""
    swept = _nested(problem, "nsgs", spent, limit=SWEEPS)
    return start if start is not None and residual(problem, start) < residual(problem, swept) else swept


def _near(problem: FrictionProblem, system: System, impulse: Array) -> Iterator[Phase]:
    """The predictor-corrector around impulses (nc, d) that nearly are a solution, otherwise nothing."""
    if residual(problem, impulse) <= NEARLY_SOLVED:
        yield predictor_corrector, _around(problem, system, impulse, LEAST_DISTANCE), PHASE_SHARE


def _generic(system: System, impulse: float, speed: float, wide: float) -> Point:
    """A start in space from constants, with the friction limit mu c: for large mu paths from other starts do not converge."""
    point = start_point(system, impulse, speed)
    point.s[:, 3] *= np.maximum(system.friction, 1)
    return _widened(point, wide)


def _loaded(system: System, share: float) -> Point:
    """A start in space with the impulse that stops a unit velocity of the heaviest contact; share < 1: less at lighter ones."""
    point = _generic(system, 1.0, 1.0, 1.0)
    ratio = (system.weight / system.weight.min()) ** share
    point.x[:, 0] *= ratio
    point.s[:, 3] *= ratio
    return point


def _widened(point: Point, wide: float) -> Point:
    """A point in space with its friction's products `wide` times larger."""
    point.x[:, 3] *= wide
    point.s[:, 1:3] *= wide
    return point


def _around(problem: FrictionProblem, system: System, impulse: Array, least: float) -> Point:
    """The centred point around impulses (nc, d), whose distance from the boundary is their residual, but at least `least`."""
    distance = max(residual(problem, impulse), least)
    return centred_point(system, space_of(system), impulse, problem.contact_velocity(impulse), distance)
