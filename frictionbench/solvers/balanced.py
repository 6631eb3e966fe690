"""Balancing of problems with islands of unlike speeds, and confirmation of claims on problems with joints.

Our methods and outside libraries scale a problem and its tolerance by the fastest contact, so that an island that is much
slower would be left unsolved. If the units of the islands differ by more than a factor UNLIKE, a solver receives the problem
with its islands in like units (FrictionProblem.balanced), and its impulses are converted back. Active sets, which are `exact`
as no tolerance changes their answers, receive problems of bodies as they are: only islands unlike by 1e12 change these. Outside
libraries are not called for problems without contacts: the form step returns the answer, and the other steps pass it on.
With joints W may have lost digits: a claim of a method of this package counts only if the residual confirms it.
"""

from dataclasses import replace
from functools import wraps
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.answer import Answer, Status
from frictionbench.problems.check import Array
from frictionbench.problems.forms.lcp import by_unknown
from frictionbench.problems.residual import contact_floors, contact_residuals, largest

UNLIKE = 4.0  # a tolerance that is smaller by less than this factor costs next to nothing


class Balanced(NamedTuple):
    """The result of a solver's step, the factors (nc,) of its impulses, and the problem if claims have to be confirmed."""

    step: Any
    factor: Array
    jointed: FrictionProblem | None


def with_balance(cls: Any, model: str, outside: bool) -> Any:
    """Wrap the steps of the class to balance the problem and convert the answer; inherited ones are already wrapped."""
    for name, balance in (("form", _form), ("setup", _setup), ("solve", _solve), ("begin", _solve)):
        step = getattr(cls, name, None)
        if step and not hasattr(step, "__wrapped__"):
            setattr(cls, name, wraps(step)(balance(step)))
    cls.is_outside, cls.usual_model, cls.has_relaxed_units = outside, model, model in ("relaxation", "regularised")
    return cls


def _form(form: Any) -> Any:
    def balanced(self: Any, problem: Any) -> Any:
        of_contacts = isinstance(problem, FrictionProblem)  # otherwise a bare LCP
        if self.is_outside and not (problem.contacts if of_contacts else len(problem.q)):
            z = np.zeros(0) if getattr(self, "model", self.usual_model) == "lcp" else None
            return Answer(np.zeros((0, getattr(problem, "dimension", 0))), Status.SOLVED, z=z)
        if not of_contacts:
            return form(self, problem)
        relaxed, polygon = self.has_relaxed_units, self.usual_model == "lcp" and problem.dimension == 3  # W defines its LCP
        jointed = problem if problem.contacts and len(problem.joint_bias) and not (self.is_outside or polygon) else None
        alike = problem.mechanical and getattr(self, "exact", False)
        alike = alike or (problem.relaxation_spread if relaxed else problem.spread) <= UNLIKE
        if alike and jointed is None:
            return form(self, problem)
        same, factor = (problem, np.ones(problem.contacts)) if alike else problem.balanced(relaxed)
        return Balanced(form(self, same), factor, jointed)

    return balanced


def _setup(setup: Any) -> Any:
    def balanced(self: Any, formed: Any) -> Any:
        if type(formed) is Balanced:
            return formed._replace(step=setup(self, formed.step))
        return formed if type(formed) is Answer else setup(self, formed)

    return balanced


def _solve(solve: Any) -> Any:
    def balanced(self: Any, prepared: Any, tol: float, limit: int | None, start: Array | None = None) -> Any:
        if type(prepared) is Answer:
            return replace(prepared)
        if type(prepared) is not Balanced:
            return solve(self, prepared, tol, limit, start)
        step, factor, jointed = prepared
        guess = None if start is None else np.ascontiguousarray(start / factor[:, None])
        answer = solve(self, step, tol, limit, guess)
        z = None if answer.z is None else answer.z * by_unknown(factor, len(answer.z))
        answer = replace(answer, impulse=answer.impulse * factor[:, None], z=z)
        if jointed is not None and answer.status is Status.SOLVED:
            arguments = jointed, answer.impulse, 0.0 if self.has_relaxed_units else 1.0
            error = largest(contact_residuals(*arguments))
            if error > tol and error > largest(contact_floors(*arguments)):
                answer.status = Status.BREAKDOWN
        return answer

    return balanced
