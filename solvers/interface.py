"""What a solver is: a name, a few facts about it, and three steps, each timed apart.

    @solver("lemke", family="pivoting", model="lcp", dimension=(2, 3), warm_start=True)
    class Lemke:
        restarts: int = 8                            # fields are variants: lemke[restarts=0]

        def form(self, problem): ...                 # the problem written as what the method takes: an LCP, a QP, scaled
        def setup(self, formed): ...                 # the method's or library's own: orderings, workspaces, factors
        def solve(self, prepared, tol, limit, start=None) -> Answer: ...

A solver without form or setup needs none: the next step is given what the last one had. One that tells the two not apart
defines `prepare(problem)` instead, which counts as setup. Every solver then has `prepare`, which is setup(form(problem)).

`tol` is the residual asked for, of the solver's own model in the measure of problems.residual. One that computes this very
residual stops at tol; one that stops by another measure keeps a margin, as much as that can fall short of this one:

    1      sweeps, projected gradients and splittings: their residual is the verifier's, to the last bits
    1/2    interior points and pivoting: the same in other units and by rows, a contact's normal and tangent apart, together
           sqrt(2) as much, and added up in another order
    1/10   Newton's methods on an LCP: its natural residual bounds this one up to a small factor (solvers.pivots.natural)
    own    outside libraries: each file in solvers/outside says what it asks for, and why

What a margin cannot promise is found out by the verifier, and is `missed` or `wrong` (harness.verify). `limit` bounds the
method's own unit of work (pivots, sweeps, iterations), None for its default: wall-clock limits are the harness's business.
`start` is a guess of the impulses (nc, d), given only to solvers with warm_start. A solver says honestly how it ended;
whether its answer is right is found out by others.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from numbers import Integral, Real
from typing import Any, Literal, Protocol, TypeVar

import numpy as np

from frictionbench.problems import LCP, FrictionProblem, InputError, check
from frictionbench.problems.check import Array, require
from frictionbench.problems.spec import split
from frictionbench.solvers.needs import installed

Model = Literal["coulomb", "lcp", "relaxation", "regularised"]
MOST_WORK = 10**8  # the largest limit that may be given: histories of that length are allocated


class Status(Enum):
    """How a solver says that it ended; the values are messages. A claim only: `verify` finds out whether the answer is right.

    >>> import frictionbench as fb
    >>> fb.Status.STALLED.value
    'no further progress was possible'
    """

    SOLVED = "solved to the tolerance asked for"
    RAY = "ended on a secondary ray whose certificate holds: no solution on this path"
    WORK_LIMIT = "the work limit was reached first"
    STALLED = "no further progress was possible"
    BREAKDOWN = "the arithmetic broke down"
    FAILED = "the outside library reports a failure"


@dataclass(eq=False, slots=True)
class Answer:
    """What a solver gives back.

    impulse: (nc, d), N s, normal first; (0, 0) for a bare LCP. z: (n,), for solvers of LCPs.
    work: deterministic counts by name (pivots, sweeps, iterations, factorisations).
    history: the method's own measure of progress, one number an iteration, where it has one.
    detail: the outside library's own words, or a reason.
    clock: s, the library's own time of its solve, where it keeps one; the harness times the whole call besides.
    softness: (nc, d), 1/kg, of a solver of regularised contacts: the R >= 0 with which it made u = W r + q + R r;
        harness.verify says how large that may be.

    >>> import frictionbench as fb
    >>> answer = fb.solve(fb.scene("stack", blocks=2).problem(), "lemke")
    >>> answer.impulse.shape, answer.status.name, sorted(answer.work)[-1]
    ((4, 2), 'SOLVED', 'restarts')
    """

    impulse: Array
    status: Status
    work: dict[str, int] = field(default_factory=dict)
    history: tuple[float, ...] = ()
    z: Array | None = None
    detail: str = ""
    clock: float | None = None
    softness: Array | None = None


class Solver(Protocol):
    """An instance of a class decorated with @solver."""

    def form(self, problem: Any) -> Any: ...

    def setup(self, formed: Any) -> Any: ...

    def prepare(self, problem: Any) -> Any: ...

    def solve(self, prepared: Any, tol: float, limit: int | None, start: Array | None = None) -> Answer: ...


@dataclass(frozen=True)
class SolverInfo:
    """The facts about a solver.

    model: what it solves: "coulomb" the friction problem itself, "lcp" its LCP (the same in the plane, polygonal in space;
    such a solver also takes a bare LCP), "relaxation" the convex relaxation, "regularised" that with soft contacts.
    needs: what must be installed, as solvers.needs has it. sparse: whether it stays sparse on large problems.
    lacks: the problem's fields that it knows nothing of, friction_bias or joints, and so takes no problem with one.
    variants: the settings that are solvers of their own, as in `ccp[backend=clarabel]`. A variant that differs in model,
    dimension, needs or lacks has an attribute of that name. members: the solvers it may run, where it is a portfolio.
    """

    name: str
    family: str
    model: Model
    dimension: tuple[int, ...]
    warm_start: bool
    sparse: bool
    needs: tuple[str, ...]
    lacks: tuple[str, ...]
    variants: tuple[str, ...]
    members: tuple[str, ...]
    make: Callable[..., Solver]

    @property
    def ours(self) -> bool:
        """Whether this package defines it, be the method ours or a library's; a plug-in's is not."""
        return self.make.__module__.startswith("frictionbench.solvers.")

    @property
    def specs(self) -> tuple[str, ...]:
        """How the command line names it, each of its variants apart."""
        return tuple(f"{self.name}[{settings}]" for settings in self.variants) or (self.name,)

    @property
    def summary(self) -> str:
        """The first line of the class's docstring."""
        return (self.make.__doc__ or "").strip().splitlines()[0]

    @property
    def missing(self) -> str | None:
        """Why the solver cannot be used here, or None."""
        absent = [need for need in self.needs if installed(need) is None]
        return f"{', '.join(absent)} not installed" if absent else None

    @property
    def version(self) -> str:
        """What it needs with its versions, where it is there; nothing for our own."""
        return ", ".join(f"{need} {installed(need) or ''}".strip() for need in self.needs)

    def refuses(self, problem: FrictionProblem | LCP) -> str | None:
        """Why this solver does not take the problem, or None."""
        if isinstance(problem, LCP):
            return None if self.model == "lcp" else f"{self.name} solves friction problems, not bare LCPs"
        if problem.dimension not in self.dimension:
            return f"{self.name} does not take contacts of dimension {problem.dimension}"
        present = [field for field in self.lacks if abs(getattr(problem, field)).sum() > 0]
        return f"{self.name} takes no {', '.join(present)}" if present else None


_solvers: dict[str, SolverInfo] = {}
Class = TypeVar("Class", bound=type)


def solver(
    name: str,
    *,
    family: str,
    model: Model,
    dimension: tuple[int, ...] = (2,),
    warm_start: bool = False,
    sparse: bool = False,
    needs: tuple[str, ...] = (),
    lacks: tuple[str, ...] = (),
    variants: tuple[str, ...] = (),
    members: tuple[str, ...] = (),
) -> Callable[[Class], Class]:
    """Make a class a frozen dataclass whose fields are its settings, give it the steps it leaves out, and list it as `name`.

    family: of methods, as reports group them. Other arguments: see SolverInfo. The class needs
    `solve(self, prepared, tol, limit, start=None) -> Answer`, and may have `form`, `setup` or `prepare`.
    Errors: ValueError where the name is taken, or the class has `prepare` beside `form` or `setup`.

    >>> import frictionbench as fb, numpy as np
    >>> @fb.solver("nothing", family="splitting", model="coulomb", dimension=(2, 3))
    ... class Nothing:
    ...     "No impulses at all."
    ...
    ...     def solve(self, problem, tol, limit, start=None):
    ...         return fb.Answer(np.zeros((problem.contacts, problem.dimension)), fb.Status.FAILED)
    >>> fb.solve(fb.scene("stack", blocks=2).problem(), "nothing").status.name
    'FAILED'
    """

    def register(cls: Class) -> Class:
        made: Any = dataclass(frozen=True)(with_all_steps(cls))
        if name in _solvers:
            raise ValueError(f"solver: the name {name!r} is taken by {_solvers[name].make}")
        facts = (family, model, dimension, warm_start, sparse, needs, lacks, variants, members)
        _solvers[name] = SolverInfo(name, *facts, made)
        return made

    return register


def with_all_steps(cls: Any) -> Any:
    """The class with form, setup and prepare. Errors: ValueError where it has a prepare of its own beside one of the two."""
    prepare = getattr(cls, "prepare", _form_and_set_up)
    if prepare is not _form_and_set_up:
        if {"form", "setup"} & vars(cls).keys():
            raise ValueError(f"solver: {cls.__name__} has a prepare of its own, and form or setup beside it")
        cls.form, cls.setup = _hand_on, prepare
    for step in ("form", "setup"):
        if not hasattr(cls, step):
            setattr(cls, step, _hand_on)
    cls.prepare = _form_and_set_up
    return cls


def _hand_on(self: Solver, given: Any) -> Any:
    return given


def _form_and_set_up(self: Solver, problem: Any) -> Any:
    return self.setup(self.form(problem))


def available() -> dict[str, SolverInfo]:
    """All known solvers by name, a SolverInfo each; `missing` says why one cannot be used here, `summary` what it is.

    >>> import frictionbench as fb
    >>> fb.available()["lemke"].missing is None
    True
    """
    return dict(_solvers)


def find(spec: str) -> tuple[SolverInfo, Solver]:
    """The facts and an instance for a name with optional settings, like `nsgs[relaxation=1.3]`.

    Errors: InputError naming the solver, or the setting, that is unknown or of the wrong kind.
    """
    if spec in _found and _found[spec][0].name in _solvers:
        return _found[spec]
    name, settings = split("solver", spec)
    if name not in _solvers:
        raise InputError(f"solver: unknown solver {name!r}; known are {', '.join(sorted(_solvers))}")
    info = _solvers[name]
    instance: Any = info.make()
    kinds = {entry.name: type(getattr(instance, entry.name)) for entry in fields(instance)}
    values = {}
    for key, text in settings.items():
        if key not in kinds or text is None:
            raise InputError(f"solver: {name} has no setting {key!r}; it has {', '.join(kinds) or 'none'}")
        try:
            values[key] = _FLAGS[text.lower()] if kinds[key] is bool else kinds[key](text)
        except (ValueError, KeyError):
            raise InputError(f"solver: {name}[{key}=...] takes a {kinds[key].__name__}, got {text!r}") from None
    try:
        made = replace(instance, **values)
    except ValueError as error:
        raise InputError(f"solver: {spec}: {error}") from None
    _found[spec] = replace(info, **{fact: getattr(made, fact) for fact in _OF_A_VARIANT if hasattr(made, fact)}), made
    return _found[spec]


_found: dict[str, tuple[SolverInfo, Solver]] = {}  # instances are frozen, so each is made once
_OF_A_VARIANT = ("model", "dimension", "needs", "lacks")
_FLAGS = {"true": True, "false": False, "1": True, "0": False}


def solve(
    problem: FrictionProblem | LCP, spec: str, *, tol: float = 1e-8, limit: int | None = None, start: Array | None = None
) -> Answer:
    """Prepare and solve one problem with one solver, in this process and without a time limit.

    problem: a FrictionProblem of nc contacts of dimension d, or a bare LCP for solvers of LCPs.
    spec: a solver's name, with settings in brackets if any: "lemke", "nsgs[relaxation=1.3]". See `available`.
    tol: the residual asked for, dimensionless, > 0: the largest defect of the solver's model at a contact, as a velocity over
        the largest free contact velocity (problems.residual). For a bare LCP max|min(z, w)| over max|q|.
    limit: most pivots, sweeps or iterations, whatever the method counts; None for the method's own limit.
    start: (nc, d), N s, normal first: a guess of the impulses. A solver without warm start ignores it.

    Returns an Answer: impulse (nc, d) in N s, normal first, also where the solver failed; status, what the solver claims;
    work, its counts; z (n,) of solvers of LCPs.
    Errors: InputError for an unknown or unavailable solver or one that does not take this problem, and naming problem, tol,
    limit or start where that cannot be used.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2, push=1.0).problem()
    >>> cold = fb.solve(problem, "nsgs", tol=1e-6)
    >>> warm = fb.solve(problem, "nsgs", tol=1e-6, start=cold.impulse)
    >>> cold.status.name, warm.work["sweeps"] < cold.work["sweeps"]
    ('SOLVED', True)
    """
    info, instance = find(spec)
    if not isinstance(problem, FrictionProblem | LCP):
        raise InputError(f"problem: must be a FrictionProblem or an LCP, got {type(problem)}")
    if not (isinstance(tol, Real) and 0 < tol < float("inf")):
        raise InputError(f"tol: must be a positive, finite number, got {tol!r}")
    if limit is not None:
        whole = isinstance(limit, Integral) and not isinstance(limit, bool)
        allowed = whole and 1 <= limit <= MOST_WORK
        require(allowed, "limit", f"must be a whole number, at least 1 and at most {MOST_WORK}, got {limit!r}")
    if reason := info.missing or info.refuses(problem):
        raise InputError(f"solver: {reason}")
    shape = problem.contacts if isinstance(problem, LCP) else (problem.contacts, problem.dimension)
    guess = None if start is None else impulses(start, shape)
    return instance.solve(instance.prepare(problem), float(tol), limit, guess if info.warm_start else None)


def impulses(start: Any, shape: tuple[int, ...]) -> Array:
    """A copy of the impulses (nc, d) to start from, zeros for None. Errors: InputError naming start."""
    if start is None:
        return np.zeros(shape)
    guess = check.floats("start", start)
    require(guess.shape == shape, "start", f"expected impulses of shape {shape}, got {guess.shape}")
    require(bool(np.isfinite(guess).all()), "start", "must be finite")
    return guess
