"""The verdict on one answer, as in a benchmark run."""

from frictionbench.problems import LCP, FrictionProblem, InputError, verify as verifier
from frictionbench.problems.answer import AnswerError, checked_copy
from frictionbench.problems.check import require
from frictionbench.problems.friction import require_problem
from frictionbench.problems.verify import Finding
from frictionbench.solvers import Answer, find
from frictionbench.solvers.interface import tolerance

COULOMB_SOLVER = "nsgs"  # a solver of Coulomb's law, whose answers are verified on the exact problem only


def verify(problem: FrictionProblem | LCP, answer: Answer, tol: float, *, solver: str | None = None) -> Finding:
    """Verify an answer independently of the solver that gave it.

    problem: the problem solved; for an LCP the answer must have z. answer: as `solve` returns it; its status counts only as a
    claim. tol: the bound on the residual, a relative contact velocity, > 0. solver: the name of the solver, with settings if
    any; by default answer.solver. An answer to the convex relaxation, with a polygonal cone or with regularised contacts is
    also measured on that model, and may be "relaxed". If neither names a solver, it is judged only on the exact problem.

    Returns a frozen Finding: verdict, reason, residual, model_residual, floor, fclib_error and energy_defect; `help` of
    its type describes them with units.
    Errors: InputError naming problem, answer and its field that is not an array of numbers, tol or solver.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2, push=1.0).problem()
    >>> found = fb.verify(problem, fb.solve(problem, "nsgs", tol=1e-6), tol=1e-6)
    >>> found.verdict.value, found.residual <= 1e-6
    ('solved', True)
    """
    require_problem(problem)
    require(isinstance(answer, Answer), "answer", f"must be an Answer, got {type(answer)}; fb.residual takes impulses")
    info, _ = find((answer.solver or COULOMB_SOLVER) if solver is None else solver)
    try:
        answer = checked_copy(answer)
    except AnswerError as error:
        raise InputError(f"answer: {error}") from None
    return verifier.verify(problem, answer, info.model, tolerance(tol), quiet=bool(info.needs))
