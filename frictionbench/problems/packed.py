"""Problems of any sizes packed one after another into flat arrays, so that one compiled loop processes all of them.

For each problem the arrays contain either its mechanics, without joints, or its Delassus matrix by blocks. Problem k has the
entries first[k, a] to first[k + 1, a] of the a-th array. The kernels are those of problems.mechanics, applied to the pieces of
one problem, so that the results are the same to the last bit.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems.check import Array, require
from frictionbench.problems.compiled import inlined, lean_loop, loop
from frictionbench.problems.forms.delassus import (
    known_measures,
    measures,
    write_act,
    write_contact_velocity,
    write_velocity,
)
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.residual import largest_with_floor
from frictionbench.problems.rows import Index32, Index64


class Packed(NamedTuple):
    """N problems with contacts of dimension d. first: (N+1, 17), a column for each of the other arrays up to q.

    friction, friction_bias: of all contacts. start, column, J (entries, d): J by contacts (problems.rows). m_start, m_column,
    m_value: M^-1 by rows. mass_start, mass_column, mass_value: M by rows. free: v*. bias: b. w_start, neighbours, block: W by
    blocks (problems.forms.delassus). Starts count within a problem. q (contacts*d,), scale, units (contacts,), spread (N,): as
    in FrictionProblem. offset: (contacts, d), as in FrictionProblem, but zero if only W is known.
    """

    friction: Array
    friction_bias: Array
    start: Index32
    column: Index32
    J: Array
    m_start: Index32
    m_column: Index32
    m_value: Array
    mass_start: Index32
    mass_column: Index32
    mass_value: Array
    free: Array
    bias: Array
    w_start: Index32
    neighbours: Index32
    block: Array
    q: Array
    first: Index64
    offset: Array
    scale: Array
    units: Array
    spread: Array

    @property
    def dimension(self) -> int:
        """d, of all contacts."""
        return int(self.J.shape[1])

    @property
    def size(self) -> int:
        """N, the number of problems."""
        return len(self.first) - 1

    @property
    def contacts(self) -> Index64:
        """(N+1,): the start of each problem's contacts, relative to that of the first problem."""
        return self.first[:, CONTACT] - self.first[0, CONTACT]

    @property
    def velocities(self) -> Index64:
        """(N+1,): the start of each problem's velocities, which are those of the contacts if only W is known."""
        known = np.diff(self.first[:, START]) == 0
        nv = np.where(known, np.diff(self.first[:, Q]), np.diff(self.first[:, VELOCITY]))
        return np.concatenate([[0], np.cumsum(nv)])

    def part(self, begin: int, end: int) -> "Packed":
        """Problems begin, ..., end - 1, without a copy."""
        return self._replace(first=self.first[begin : end + 1], spread=self.spread[begin:end])


# Columns of first.
CONTACT, _, START, COLUMN, _, M_START, M_COLUMN, _, MASS_START, MASS_COLUMN, _, VELOCITY, BIAS, W_START, BLOCK, _, Q = range(17)
SAME = {1: CONTACT, 4: COLUMN, 7: M_COLUMN, 10: MASS_COLUMN, 15: BLOCK}  # arrays that have the starts of another
NONE, NOTHING = np.zeros(0, np.int32), np.zeros(0)
NO_BLOCKS = {d: np.zeros((0, d, d)) for d in (2, 3)}


def pack(problems: Sequence[FrictionProblem]) -> Packed:
    """Pack problems of one dimension and without joints."""
    arrays = list(zip(*map(_pieces, problems), strict=True))
    first = np.zeros((len(problems) + 1, len(arrays)), np.int64)
    for a, pieces in enumerate(arrays):
        same = SAME.get(a)
        first[1:, a] = np.fromiter(map(len, pieces), np.int64, len(problems)).cumsum() if same is None else first[1:, same]
    first[:, Q] = first[:, CONTACT] * problems[0].dimension
    packed = Packed._make((*map(np.concatenate, arrays), first, NOTHING, NOTHING, NOTHING, NOTHING))
    offset = np.zeros((len(packed.friction), problems[0].dimension))
    offset[np.repeat(np.diff(first[:, START]) > 0, np.diff(first[:, CONTACT])), 0] = packed.bias
    packed = packed._replace(offset=offset)
    for array in (*packed[:2], packed.free, packed.bias, packed.q, offset):  # as in a problem, so that kernels see equal types
        array.setflags(write=False)
    q, scale, units, spread = _measured(packed)
    q.setflags(write=False)
    units.setflags(write=False)
    return packed._replace(q=q, scale=scale, units=units, spread=spread)


def _pieces(problem: FrictionProblem) -> tuple[Any, ...]:
    law, d = (problem.friction, problem.friction_bias), problem.dimension
    if problem.mechanical:
        rows = *problem.contact_rows, *problem.inverse_rows, *problem.mass_rows, problem.free_velocity, problem.bias
        return *law, *rows, NONE, NONE, NO_BLOCKS[d], NOTHING
    unmoved = NONE, NONE, np.zeros((0, d)), NONE, NONE, NOTHING, NONE, NONE, NOTHING, NOTHING, NOTHING
    return *law, *unmoved, *problem.blocks, problem.q


class Batch:
    """Friction problems packed once, to be solved by `solve_many` any number of times.

    problems: FrictionProblems of any sizes, planar, spatial, or both. Errors: InputError naming an entry that is not one.

    groups: the packed planar and spatial problems, each with their numbers. Problems with joints are in no group and are solved
    one by one. dimension (N,): of the contacts. first (N+1,): the start of each problem's impulses in a flat array.

    >>> import frictionbench as fb
    >>> batch = fb.Batch(fb.scene("stack", blocks=n, push=1.0).problem() for n in (1, 2, 3))
    >>> len(batch), batch.first.tolist()
    (3, [0, 4, 12, 24])
    """

    problems: tuple[FrictionProblem, ...]
    groups: tuple[tuple[Index64, Packed], ...]
    dimension: Index64
    first: Index64

    def __init__(self, problems: Iterable[FrictionProblem]) -> None:
        require(isinstance(problems, Iterable), "problems", f"must be a sequence of FrictionProblems, got {type(problems)}")
        self.problems = tuple(problems)
        members: dict[int, list[int]] = {}
        sizes = []
        for k, problem in enumerate(self.problems):
            require(isinstance(problem, FrictionProblem), f"problems[{k}]", f"must be a FrictionProblem, got {type(problem)}")
            sizes.append(problem.contacts * problem.dimension)
            if not (problem.mechanical and len(problem.joint_bias)):
                members.setdefault(problem.dimension, []).append(k)
        numbers = [np.array(which) for which in members.values()]
        self.groups = tuple((which, pack([self.problems[k] for k in which])) for which in numbers)
        self.dimension = np.array([problem.dimension for problem in self.problems], np.int64)
        self.first = np.concatenate([[0], np.cumsum(np.array(sizes, np.int64))])

    def __len__(self) -> int:
        return len(self.problems)

    def __iter__(self) -> Iterator[FrictionProblem]:
        return iter(self.problems)

    def __repr__(self) -> str:
        return f"Batch({len(self)} problems)"


@inlined
def law_of(packed, k):  # type: ignore[no-untyped-def]
    """Problem k's friction, friction_bias, scale and units (nc,)."""
    begin, end = packed.first[k, CONTACT], packed.first[k + 1, CONTACT]
    return packed.friction[begin:end], packed.friction_bias[begin:end], packed.scale[begin:end], packed.units[begin:end]


@inlined
def mechanical(packed, k):  # type: ignore[no-untyped-def]
    """Whether problem k is given by its mechanics."""
    return packed.first[k + 1, START] > packed.first[k, START]


@inlined
def mechanics_of(packed, k):  # type: ignore[no-untyped-def]
    """Problem k's J by contacts, M^-1 by rows, v* and b."""
    a, b = packed.first[k], packed.first[k + 1]
    return (
        packed.start[a[START] : b[START]],
        packed.column[a[COLUMN] : b[COLUMN]],
        packed.J[a[COLUMN] : b[COLUMN]],
        packed.m_start[a[M_START] : b[M_START]],
        packed.m_column[a[M_COLUMN] : b[M_COLUMN]],
        packed.m_value[a[M_COLUMN] : b[M_COLUMN]],
        packed.free[a[VELOCITY] : b[VELOCITY]],
        packed.bias[a[BIAS] : b[BIAS]],
    )


@inlined
def mass_of(packed, k):  # type: ignore[no-untyped-def]
    """Problem k's M by rows."""
    a, b = packed.first[k], packed.first[k + 1]
    entries = slice(a[MASS_COLUMN], b[MASS_COLUMN])
    return packed.mass_start[a[MASS_START] : b[MASS_START]], packed.mass_column[entries], packed.mass_value[entries]


@inlined
def known_blocks(packed, k):  # type: ignore[no-untyped-def]
    """Problem k's W by blocks, if only W is known."""
    a, b = packed.first[k], packed.first[k + 1]
    block = slice(a[BLOCK], b[BLOCK])
    return packed.w_start[a[W_START] : b[W_START]], packed.neighbours[block], packed.block[block]


@loop
def _measured(packed):  # type: ignore[no-untyped-def]
    """q, scale and units of all contacts, and each problem's spread."""
    count, d = len(packed.first) - 1, packed.J.shape[1]
    contacts = packed.first[count, CONTACT]
    q, scale, units, unlike = np.empty(contacts * d), np.empty(contacts), np.empty(contacts), np.empty(count)
    at, none = 0, np.zeros(0)
    for k in range(count):
        begin, end = packed.first[k, CONTACT], packed.first[k + 1, CONTACT]
        b_f = packed.friction_bias[begin:end]
        if mechanical(packed, k):
            own_q, own_scale, _, unit, unlike[k] = measures(*mechanics_of(packed, k), b_f, none)
        else:
            own_q = packed.q[at : at + (end - begin) * d].copy()
            at += len(own_q)
            own_scale, unit, unlike[k] = known_measures(*known_blocks(packed, k), own_q, b_f, none)
        for i in range(end - begin):
            scale[begin + i], units[begin + i] = own_scale[i], unit[i]
            for a in range(d):
                q[(begin + i) * d + a] = own_q[i * d + a]
    return q, scale, units, unlike


def residuals(packed: Packed, impulse: Array) -> Array:
    """(N, 2): each problem's residual and its floor (problems.residual), for the impulses of all contacts (contacts, d)."""
    contacts, velocities = np.diff(packed.contacts).max(initial=0), np.diff(packed.first[:, VELOCITY]).max(initial=0)
    errors = np.empty((packed.size, 2))
    _residuals(packed, impulse, np.empty((2, velocities)), np.empty((2, contacts, packed.dimension)), errors)
    return errors


@lean_loop
def _residuals(packed, impulse, by_velocity, by_contact, errors):  # type: ignore[no-untyped-def]
    """Write `residuals` to errors (N, 2). by_velocity (2, nv), by_contact (2, nc, d): workspace for the largest problem."""
    begin = packed.first[0, CONTACT]
    for k in range(len(errors)):
        r = impulse[packed.first[k, CONTACT] - begin : packed.first[k + 1, CONTACT] - begin]
        u, terms = by_contact[0, : len(r)], by_contact[1, : len(r)]
        mu, wider, scale, units = law_of(packed, k)
        if mechanical(packed, k):
            start, column, J, m_start, m_column, m_value, free, bias = mechanics_of(packed, k)
            momentum, pushed = by_velocity[0], by_velocity[1]
            mechanics = start, column, J, m_start, m_column, m_value, free, r
            write_velocity(*mechanics, False, momentum, pushed)
            write_contact_velocity(start, column, J, pushed, bias, False, u)
            write_velocity(*mechanics, True, momentum, pushed)
            write_contact_velocity(start, column, J, pushed, bias, True, terms)
        else:
            first, neighbours, block = known_blocks(packed, k)
            q = packed.q[packed.first[k, Q] : packed.first[k + 1, Q]].reshape(len(r), r.shape[1])
            write_act(first, neighbours, block, r, q, False, u)
            write_act(first, neighbours, block, r, q, True, terms)
        errors[k, 0], errors[k, 1] = largest_with_floor(r, u, terms, scale, mu, wider, units)
