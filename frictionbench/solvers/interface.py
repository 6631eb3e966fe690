"""The interface of a solver: a name, its properties, and three steps that are timed separately.

    @solver("lemke", family="pivoting", model="lcp", dimension=(2, 3), warm_start=True)
    class Lemke:
        restarts: int = 8                            # fields are variants: lemke[restarts=0]

        def form(self, problem): ...                 # the problem in the form the method takes: an LCP, a QP, scaled
        def setup(self, formed): ...                 # the method's or library's preparation: orderings, workspaces, factors
        def solve(self, prepared, tol, limit, start=None) -> Answer: ...

A missing `form` or `setup` passes its argument on unchanged. Every registered solver has `prepare`: setup(form(problem)).

`tol` is the requested residual of the solver's own model, as defined in problems.residual: the defect of each contact is
measured in its own unit of velocity, `problem.units` (nc,), that of its island. A solver that stops by a single velocity stops
at tol * problem.units.min(), or solves `problem.balanced()`, where separate islands have like units; this is done for the
solvers of this package (solvers.balanced). A solver that computes this residual stops at tol. A solver with another stopping
criterion requests less, by the factor by which its criterion can underestimate the residual:

    1      sweeps, projected gradients and splittings: their residual equals the verifier's up to rounding
    1/2    interior points and methods on an LCP: other units, normal and tangential rows of a contact measured separately,
           which differs by up to sqrt(2), and another order of summation
    own    outside libraries: each file in solvers/outside states what is requested of the library, and why

If the residual exceeds tol nevertheless, the verifier reports `near_miss` or `wrong` (problems.verify). `limit` bounds the work
in the method's own unit (pivots, sweeps, iterations), None for its default; wall-clock limits are enforced by the harness.
`start` is an initial guess of the impulses (nc, d), passed only to solvers with warm_start.

A solver may also have a method solve_many(self, packed, tol, limit, start=None) -> Solved. It solves the problems of a
problems.packed.Packed, all of one dimension and without joints, and returns the impulses that `solve` would return. start:
impulses of all contacts (contacts, d). It may be called in several threads at once, for different shares of the problems.
"""

import math
import re
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, fields, replace
from inspect import signature
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import LCP, FrictionProblem, InputError, check
from frictionbench.problems.analysis.contradiction import contradiction
from frictionbench.problems.answer import Answer, Status
from frictionbench.problems.catalogue import near
from frictionbench.problems.check import Array, require
from frictionbench.problems.forms.definite import FILE_ROUNDING
from frictionbench.problems.friction import require_problem
from frictionbench.problems.residual import residual, residual_with_floor
from frictionbench.problems.rows import Index64
from frictionbench.problems.spec import split
from frictionbench.problems.verdicts import SINGLE
from frictionbench.solvers.balanced import with_balance
from frictionbench.solvers.clock import TimeLimit, is_over
from frictionbench.solvers.needs import LICENSED, installed_version

__all__ = ["Answer", "Solved", "Solver", "SolverInfo", "Status", "available", "find", "solve", "solver"]

Model = Literal["coulomb", "lcp", "relaxation", "regularised"]
Precision = Literal["double", "single"]
FINEST_TOL = {"double": 0.0, "single": 1e-6}  # the tightest target: float32 has a rounding error of 6e-8 in every operation
LACKS = ("friction_bias", "joints", "asymmetry")  # properties of a problem that a solver may declare as not supported
PACKAGE = "frictionbench.solvers."  # the modules of this package's own solvers
_LOST = (Status.RAY, Status.STALLED, Status.BREAKDOWN, Status.WORK_LIMIT)  # after these a proof of infeasibility is tried


class Solved(NamedTuple):
    """The result of a solver's solve_many for N packed problems.

    impulse: (contacts, d), N s, normal first. status: (N,), each a Status, or None for a problem to be solved by itself.
    work: counts (N,) by name.
    """

    impulse: Array
    status: NDArray[np.object_]
    work: dict[str, Index64]


class Solver(Protocol):
    """An instance of a class decorated with @solver; what the class does not define is taken from here."""

    def form(self, problem: Any) -> Any:
        return problem

    def setup(self, formed: Any) -> Any:
        return formed

    def prepare(self, problem: Any) -> Any:
        return self.setup(self.form(problem))

    def solve(self, prepared: Any, tol: float, limit: int | None, start: Array | None = None) -> Answer: ...


@dataclass(frozen=True, repr=False)
class SolverInfo:
    """The properties of a solver.

    model: the model that it solves: "coulomb" the friction problem itself, "lcp" its LCP (equivalent in the plane, polygonal in
    space; such a solver also takes a bare LCP), "relaxation" the convex relaxation, "regularised" that with soft contacts.
    dimension: of the contacts, 2 or 3 or both. warm_start: whether it uses a start.
    needs: required distributions, in the syntax of solvers.needs.
    lacks: what is not supported: friction_bias, joints, or asymmetry (of W, by methods that work in velocities: the Jacobian of
    an unsymmetric W is that of its symmetric part). Problems that have it are refused, asymmetry only above FILE_ROUNDING.
    remote: whether this package runs the library in another process; it is then timed by its own clock (Answer.clock).
    variants: settings that count as separate solvers, as in `ccp[backend=highs]`, empty for the defaults; a solver of this
    package accepts settings of type text in these combinations only. A variant with another model, dimension, needs, lacks or
    precision has an attribute of that name.
    members: the solvers that a portfolio may run.
    precision: of its arithmetic. A single-precision solver is run and ranked at tolerances and targets not below FINEST_TOL.
    make: the class, a frozen dataclass whose fields are the settings. If it stores dense matrices of the LCP's size, its
    attribute `dense_matrices` is their number; the harness skips problems for which they exceed the memory.
    """

    name: str
    family: str
    model: Model
    dimension: tuple[int, ...]
    warm_start: bool
    needs: tuple[str, ...]
    lacks: tuple[str, ...]
    remote: bool
    variants: tuple[str, ...]
    members: tuple[str, ...]
    precision: Precision
    make: Callable[..., Solver]

    def __post_init__(self) -> None:
        """Errors: ValueError naming the property that is not as described for the class."""
        named, has_family = isinstance(self.name, str) and re.fullmatch(r"[\w.-]+", self.name), isinstance(self.family, str)
        self._require(bool(named), "name", "letters, digits, _, . and -")
        self._require(has_family and self.family.isprintable() and self.family.strip() != "", "family", "text")
        self._require(self.model in get_args(Model), "model", f"one of {', '.join(get_args(Model))}")
        self._require(self.dimension in ((2,), (3,), (2, 3)), "dimension", "(2,), (3,) or (2, 3)")
        self._require(self.precision in get_args(Precision), "precision", f"one of {', '.join(get_args(Precision))}")
        for flag in ("warm_start", "remote"):
            self._require(isinstance(getattr(self, flag), bool), flag, "True or False")
        for names in ("needs", "lacks", "variants", "members"):
            texts = getattr(self, names)
            self._require(isinstance(texts, tuple) and all(isinstance(each, str) for each in texts), names, "a tuple of texts")
        self._require(set(self.lacks) <= set(LACKS), "lacks", f"of {', '.join(LACKS)}")

    def _require(self, condition: bool, field: str, expected: str) -> None:
        if not condition:
            raise ValueError(f"solver: {field} must be {expected}, got {getattr(self, field)!r:.100}")

    def __repr__(self) -> str:
        return f"SolverInfo({self.name}: {self.family}, {self.model}, dimension {' and '.join(map(str, self.dimension))})"

    @property
    def ours(self) -> bool:
        """Whether this package defines it, including the adapters of outside libraries, and not a plug-in."""
        return self.make.__module__.startswith(PACKAGE)

    @property
    def specs(self) -> tuple[str, ...]:
        """The names on the command line, one for each variant."""
        return tuple(f"{self.name}[{settings}]" if settings else self.name for settings in self.variants) or (self.name,)

    @property
    def summary(self) -> str:
        """The first line of the class's docstring."""
        return (self.make.__doc__ or "").strip().partition("\n")[0]

    @property
    def missing(self) -> str | None:
        """The reason why the solver cannot be used on this machine, or None."""
        absent = [need for need in self.needs if installed_version(need) is None]
        how = "" if "@" in "".join(absent) else f"; pip install {' '.join(absent)}"  # of another Python
        licence = " or without a valid licence" if LICENSED.keys() & absent else ""
        return f"{', '.join(absent)} not installed{licence}{how}" if absent else None

    @property
    def version(self) -> str:
        """The required distributions with their installed versions; empty for our own methods."""
        return ", ".join(f"{need} {installed_version(need) or ''}".strip() for need in self.needs)

    def too_tight(self, tol: float) -> str | None:
        """The reason why this solver is not asked for a tolerance, or None."""
        finest = FINEST_TOL[self.precision]
        return f"{SINGLE}: not asked for less than {finest:g}" if tol < 0.999 * finest else None

    def refuses(self, problem: FrictionProblem | LCP) -> str | None:
        """The reason why this solver does not take the problem, or None."""
        if isinstance(problem, LCP):
            return None if self.model == "lcp" else f"{self.name} solves friction problems, not bare LCPs"
        if problem.dimension not in self.dimension:
            return f"{self.name} does not take contacts of dimension {problem.dimension}"
        digits = {"asymmetry": FILE_ROUNDING}
        present = [field for field in self.lacks if np.sum(abs(getattr(problem, field))) > digits.get(field, 0.0)]
        return f"{self.name} does not support {', '.join(present)}" if present else None


def dense_storage(instance: object, problem: FrictionProblem | LCP) -> int:
    """The bytes of the dense matrices of the LCP's size that a solver stores; `dense_matrices` of its class is their number."""
    if isinstance(problem, LCP):
        n = problem.size
    else:
        n = problem.contacts * (4 if problem.dimension == 2 else 2 + getattr(instance, "facets", 0))
    return 8 * getattr(instance, "dense_matrices", 0) * n**2


_solvers: dict[str, SolverInfo] = {}
Class = TypeVar("Class", bound=type)


def solver(
    name: str,
    *,
    family: str,
    model: Model,
    dimension: tuple[int, ...] = (2,),
    warm_start: bool = False,
    needs: tuple[str, ...] = (),
    lacks: tuple[str, ...] = (),
    remote: bool = False,
    variants: tuple[str, ...] = (),
    members: tuple[str, ...] = (),
    precision: Precision = "double",
) -> Callable[[Class], Class]:
    """Register a class as the solver `name`: a frozen dataclass whose fields are its settings, with missing steps added.

    family: of methods, as reports group them. Other arguments: see SolverInfo. The class needs
    `solve(self, prepared, tol, limit, start=None) -> Answer`, and may have `form` and `setup`.
    Errors: ValueError if the name is already registered, the class defines `prepare` or no such `solve`, or an argument is not
    as described in SolverInfo; the message names it.

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
        method: Any = getattr(cls, "solve", None)
        try:
            signature(method).bind("self", "problem", "tol", "limit", "start")
        except TypeError:
            raise ValueError(f"solver: {cls.__name__} is no class with solve(self, problem, tol, limit, start=None)") from None
        whole: Any = with_all_steps(cls)
        if whole.__module__.startswith(PACKAGE) and not getattr(whole, "takes_unlike", False):
            whole = with_balance(whole, model, bool(needs))
        made: Any = dataclass(frozen=True)(whole)
        if name in _solvers:
            raise ValueError(f"solver: the name {name!r} is already registered by {_solvers[name].make}")
        facts = (family, model, dimension, warm_start, needs, lacks, remote, variants, members, precision)
        _solvers[name] = SolverInfo(name, *facts, made)
        return made

    return register


def with_all_steps(cls: Any) -> Any:
    """Add form, setup and prepare where they are missing. Errors: ValueError if the class defines prepare."""
    if getattr(cls, "prepare", Solver.prepare) is not Solver.prepare:
        raise ValueError(f"solver: {cls.__name__} defines prepare, which is setup(form(problem)); define setup")
    for step in ("form", "setup", "prepare"):
        if not hasattr(cls, step):
            setattr(cls, step, getattr(Solver, step))
    return cls


def available() -> dict[str, SolverInfo]:
    """The SolverInfo of all registered solvers, by name; its `missing` is the reason why a solver cannot be used here, or None.

    >>> import frictionbench as fb
    >>> fb.available()["lemke"].missing is None
    True
    """
    return dict(_solvers)


def find(spec: str) -> tuple[SolverInfo, Solver]:
    """The properties and an instance of a solver, by its name with optional settings, like `nsgs[relaxation=1.3]`.

    Errors: InputError naming the solver or the setting that is unknown or has a value of the wrong type.
    """
    if not isinstance(spec, str):
        raise InputError(f"solver: expected its name as text, got {spec!r:.100}")
    if spec in _found and _found[spec][0].name in _solvers:
        return _found[spec]
    name, settings = split("solver", spec)
    if name not in _solvers:
        like = f" (did you mean the file {name}.py?)" if Path(f"{name}.py").is_file() else near(name, _solvers)
        raise InputError(f"solver: unknown solver {name!r}{like}; `frictionbench list solvers` names all")
    info = _solvers[name]
    instance: Any = info.make()
    kinds = {field.name: type(getattr(instance, field.name)) for field in fields(instance)}
    values = {}
    for key, text in settings.items():
        if key not in kinds or text is None:
            raise InputError(f"solver: {name} has no setting {key!r}{near(key, kinds)}; it has {', '.join(kinds) or 'none'}")
        try:
            values[key] = _FLAGS[text.lower()] if kinds[key] is bool else kinds[key](text)
        except (ValueError, KeyError):
            raise InputError(f"solver: {name}[{key}=...] takes a value of type {kinds[key].__name__}, got {text!r}") from None
    known = [split("solver", variant)[1] for variant in info.specs]
    chosen = {key for key, kind in kinds.items() if kind is str and any(key in variant for variant in known)}
    possible = [{key: variant.get(key, getattr(instance, key)) for key in chosen} for variant in known]
    if info.ours and {key: values.get(key, getattr(instance, key)) for key in chosen} not in possible:
        raise InputError(f"solver: {name} has no variant {spec}; it has {', '.join(info.specs)}")
    try:
        changed = replace(instance, **values)
        varied = replace(info, **{fact: getattr(changed, fact) for fact in _VARIANT_PROPERTIES if hasattr(changed, fact)})
    except ValueError as error:
        raise InputError(f"solver: {spec}: {str(error).removeprefix('solver: ')}") from None
    _found[spec] = varied, changed
    return _found[spec]


_found: dict[str, tuple[SolverInfo, Solver]] = {}  # instances are immutable, so each is made once
_VARIANT_PROPERTIES = ("model", "dimension", "needs", "lacks", "precision")
_FLAGS = {"true": True, "false": False, "1": True, "0": False}


def solve(
    problem: FrictionProblem | LCP,
    solver: str | None = None,
    *,
    tol: float = 1e-8,
    limit: int | None = None,
    start: Array | Answer | None = None,
    time_limit: float | None = None,
) -> Answer:
    """Prepare and solve one problem with one solver, in this process.

    problem: a FrictionProblem of nc contacts of dimension d, or a bare LCP for solvers of LCPs.
    solver: its name, with settings in brackets if any: "lemke", "nsgs[relaxation=1.3]". See `available`. Without one
        hybrid solves a FrictionProblem, which is fast and exact on most, and lemke a bare LCP; the answer's `solver` names it.
    tol: the requested residual, dimensionless, > 0: the largest defect of the solver's model at a contact, as a velocity over
        the contact's unit, the largest closing speed in its island (problems.residual). For a bare LCP max|min(z, w)| over
        max|q|.
    limit: the largest number of pivots, sweeps or iterations, whichever the method counts; None for the method's own limit.
    start: (nc, d), N s, normal first, or an Answer: a guess of the impulses. A solver without warm start ignores it.
    time_limit: s, > 0; None for none. Our own methods check the clock between their steps, also as members of a portfolio,
        and return the best answer so far with the status TIME_LIMIT and its residual in `detail`. Large forms, a first
        compilation and outside libraries are not interrupted; `frictionbench solve --time-limit` ends their process.

    Returns an Answer: impulse (nc, d) in N s, normal first, also if the solver failed; status, as the solver claims, except for
    solvers of this package: ROUNDING replaces SOLVED if rounding alone may leave a residual above tol (residual_floor), and
    INFEASIBLE replaces a ray, stall, breakdown or work limit on a problem that is proved to have no solution; work, its counts;
    z (n,) of solvers of LCPs.
    Errors: InputError if the solver is unknown, not installed, does not take this problem or returns no Answer, or if problem,
    tol, limit, start or time_limit is invalid; the message names which.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2, push=1.0).problem()
    >>> cold = fb.solve(problem, "nsgs", tol=1e-6)
    >>> warm = fb.solve(problem, "nsgs", tol=1e-6, start=cold)
    >>> cold.status.name, warm.work["sweeps"] < cold.work["sweeps"]
    ('SOLVED', True)
    >>> fb.solve(problem).solver
    'hybrid'
    """
    require_problem(problem)
    spec = ("lemke" if isinstance(problem, LCP) else "hybrid") if solver is None else solver
    info, instance = find(spec)
    tol, limit = tolerance(tol), work_limit(limit)
    if reason := info.missing or info.refuses(problem):
        raise InputError(f"solver: {reason}")
    shape = problem.contacts if isinstance(problem, LCP) else (problem.contacts, problem.dimension)
    guess = None if start is None else impulses(start, shape)
    with nullcontext() if time_limit is None else TimeLimit(check.number("time_limit", time_limit, above=0)):
        answer = instance.solve(instance.prepare(problem), tol, limit, guess if info.warm_start else None)
        require(isinstance(answer, Answer), "solver", f"{spec} must return an Answer, got {type(answer)}")
        late = is_over() and answer.status not in (Status.SOLVED, Status.ROUNDING)
    if time_limit is not None and (late or answer.status is Status.TIME_LIMIT):
        bare = isinstance(problem, LCP)
        error = problem.residual(answer.z) if bare else residual(problem, answer.impulse)  # type: ignore[union-attr,arg-type]
        answer.status, answer.detail = Status.TIME_LIMIT, f"after {time_limit:g} s, with a residual of {error:.2g}"
    answer.solver = spec
    claimed = answer.status is Status.SOLVED and info.ours
    if claimed and isinstance(problem, FrictionProblem) and residual_with_floor(problem, answer.impulse)[1] > tol:
        answer.status = Status.ROUNDING
    if isinstance(problem, FrictionProblem) and (proof := why_lost(info, problem, answer.status, tol)):
        answer.status, answer.detail = Status.INFEASIBLE, proof
    return answer


def why_lost(info: SolverInfo, problem: FrictionProblem, status: Status, tol: float) -> str:
    """The proof that no impulses reach tol, if a method of this package ended with a status of _LOST; otherwise empty."""
    lost = status in _LOST and info.ours and not info.needs
    proof = contradiction(problem) if lost else None
    return str(proof) if proof and proof.least_residual > tol else ""


def tolerance(tol: Any) -> float:
    """A tolerance as a float. Errors: InputError naming tol unless it is a positive, finite number."""
    return check.number("tol", tol, above=0)


def work_limit(limit: Any) -> int | None:
    """A limit of work, or None. Errors: InputError naming limit unless it is a whole number from 1 to check.LARGEST_COUNT, as
    histories of that length are allocated."""
    return None if limit is None else check.count("limit", limit)


def impulses(start: Any, shape: tuple[int, ...]) -> Array:
    """A checked copy of the impulses (nc, d) to start from, zeros for None. Errors: InputError naming start."""
    if start is None:
        return np.zeros(shape)
    guess = check.floats("start", start)
    require(guess.shape == shape, "start", f"expected impulses of shape {shape}, got {guess.shape}")
    if not math.isfinite(np.vdot(guess, guess)):  # a third of the time of isfinite of each; large entries may overflow here
        require(bool(np.isfinite(guess).all()), "start", "must be finite")
    return guess
