"""Parts of a problem that nothing connects (problems.separate), solved one by one."""

from collections.abc import Callable

from frictionbench.problems import FrictionProblem
from frictionbench.problems.residual import contact_residuals, residual
from frictionbench.problems.rows import Index64
from frictionbench.problems.separate import Parts
from frictionbench.solvers.clock import is_over
from frictionbench.solvers.interface import Answer, Status

Method = Callable[[FrictionProblem, Index64], Answer]  # of a part and its contacts


def solve_parts(problem: FrictionProblem, parts: Parts, whole: Answer, tol: float, method: Method) -> Answer:
    """An answer to the problem whose parts are solved by `method`, unless they are solved in the answer to the whole; each has
    the impulses with the smaller residual.

    The status is that of the first part that is not solved. work: that of the whole and of all parts, added up;
    history: that of the whole, then of the parts.
    """
    impulse, work, history = whole.impulse.copy(), dict(whole.work), whole.history
    by_contact, unsolved = contact_residuals(problem, impulse), None
    for contacts, part in parts:
        had = by_contact[contacts].max()
        if had <= tol:
            continue
        if is_over():
            unsolved = unsolved or Status.WORK_LIMIT
            break
        answer = method(part, contacts)
        for unit, count in answer.work.items():
            work[unit] = work.get(unit, 0) + count
        history += answer.history
        if answer.status is not Status.SOLVED:
            unsolved = unsolved or answer.status
        if not had <= residual(part, answer.impulse):
            impulse[contacts] = answer.impulse
    return Answer(impulse, unsolved or Status.SOLVED, work, history)
