"""A friction problem laid out for Newton's method in the velocities (solvers.interior.newton).

All is in units of one velocity and one impulse, the velocities of the bodies in those in which the mass matrix has a unit
diagonal. The variables are numbered in the order in which solvers.sparse_lu.multifrontal eliminates them, contacts and joints
are elements of its fronts, and what does not change from step to step, the mass matrix and the joints, is a list of numbers to
be added to them. Where only the Delassus matrix W is known, the contact velocities take the place of the bodies': M = I, J' =
W on the left of C and J = I on its right, so that an unsymmetric W is solved as given. (The other way round the rows of A = I
+ C W would be as unlike in size as sticking and open contacts, and partial pivoting misled.)
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy import sparse

from problems.check import Array
from problems.friction import DelassusProblem, FrictionProblem
from solvers.sparse_lu.minimum_degree import Index
from solvers.sparse_lu.multifrontal import Fronts, Place, analyse, find

SOFTNESS = 1e-14  # delta, relative to a contact's own mean diagonal of W; 1e-16 fails, 1e-12 slows stacks of thousands
JOINT_SOFTNESS = 1e-8  # delta of a joint; its stiffness is added to a mass matrix of size 1, so not as small as a contact's


class Elements(NamedTuple):
    """Constraints as elements of A: rows push and feel (entries, d) on the variables column[start[e]:start[e+1]].

    u = feel v and M dv = push' r; the two differ for a Delassus problem only. front, place: where an element is added.
    """

    start: Index
    column: Place
    push: Array
    feel: Array
    front: Index
    place: Place


class System(NamedTuple):
    """A friction problem in units of velocity `speed` and impulse `impulse`, its variables in order of elimination.

    slot, constant: what M + F'F/delta adds to the fronts, and where. inverse, indices, indptr: M^-1 by rows.
    shift: 0 for Coulomb's law, mu for its convex relaxation. weight: s_i of problems.residual.
    pairs: the products of a contact (solvers.interior.point): 4 in the plane, 2 in space, 1 where there is no friction at all.
    """

    fronts: Fronts
    contacts: Elements
    joints: Elements
    slot: Index
    constant: Array
    inverse: Array
    indices: Index
    indptr: Index
    free_velocity: Array
    offset: Array
    joint_bias: Array
    friction: Array
    friction_bias: Array
    shift: Array
    weight: Array
    pairs: Index
    speed: float
    impulse: float


class Work(NamedTuple):
    """Room for Newton's method on one system.

    storage, swap: the factors of A. inverse, pivot, right (nc, 4): 1/x, the pivots' inverses and g, in the plane.
    impulse and velocity (nc, d), vector and momentum (nv,), joint_velocity (nj, 1).
    """

    storage: Array
    swap: Index
    inverse: Array
    pivot: Array
    right: Array
    impulse: Array
    velocity: Array
    joint_velocity: Array
    vector: Array
    momentum: Array


@njit(cache=True)
def new_work(system: System) -> Work:
    nc, d = system.offset.shape
    nv, nj = len(system.free_velocity), len(system.joint_bias)
    return Work(
        np.zeros(system.fronts.start[-1]),
        np.zeros(nv, dtype=np.int64),
        np.zeros((nc, 4)),
        np.zeros((nc, 4)),
        np.zeros((nc, 4)),
        np.zeros((nc, d)),
        np.zeros((nc, d)),
        np.zeros((nj, 1)),
        np.zeros(nv),
        np.zeros(nv),
    )


def in_velocities(problem: FrictionProblem) -> FrictionProblem:
    """The problem, all that `prepare` reads of it computed: the free contact velocities, s, and the Jacobian or W."""
    _ = problem.q, problem.scale, problem.W if isinstance(problem, DelassusProblem) else problem.jacobian
    return problem


def prepare(problem: FrictionProblem, relaxed: bool = False) -> System:
    """Scale a problem, or its convex relaxation, find the order of elimination and lay out its matrices."""
    nc, d = problem.contacts, problem.dimension
    q = problem.q.reshape(nc, d)
    speed = float(np.sqrt(np.einsum("ij,ij->i", q, q).max(initial=0.0))) or 1.0
    impulse = speed / float(np.exp(np.log(problem.scale).mean())) if nc else speed
    if isinstance(problem, DelassusProblem):
        mass = inverse = feel = problem.mass
        push, free_velocity, offset = sparse.csr_array(problem.W.T) * (impulse / speed), problem.free_velocity, q
        unit, ratio = np.ones(nc * d), 1.0
    else:  # v = speed * unit * v^
        mass, inverse, push, free_velocity, offset = problem.velocity_form()
        feel, unit, ratio = push, np.sqrt(impulse / speed / mass.diagonal()), speed / impulse
        free_velocity = free_velocity / (unit * speed)
    fronts, place, contacts, joined, length, slot, constant = _lay_out(
        _entries(push), _entries(feel), _entries(problem.joints), _entries(mass), unit, ratio, d
    )
    value, index, start = _reorder(_entries(inverse), place, unit, ratio)
    rubs = (problem.friction > 0) | (problem.friction_bias > 0)
    return System(
        fronts,
        contacts,
        joined,
        slot,
        constant,
        value,
        index,
        start,
        _in_order(free_velocity, place),
        offset.reshape(nc, d) / speed,
        problem.joint_bias / (length * speed),
        problem.friction,
        problem.friction_bias / impulse,
        problem.friction if relaxed else np.zeros(nc),
        problem.scale * (impulse / speed),
        np.where(rubs, 4 if d == 2 else 2, 1),
        speed,
        impulse,
    )


Rows = tuple[Index, Index, Array]


def _entries(rows: sparse.csr_array) -> Rows:
    return rows.indptr, rows.indices, rows.data


def _in_order(v: Array, place: Index) -> Array:
    ordered = np.empty_like(v)
    ordered[place] = v
    return ordered


@njit(cache=True)
def _lay_out(
    push: Rows, feel: Rows, joints: Rows, mass: Rows, unit: Array, ratio: float, d: int
) -> tuple[Fronts, Index, Elements, Elements, Array, Index, Array]:
    """Fronts, places, contacts, joints, the joints' lengths, slots and constants of a System."""
    n = len(unit)
    contacts = _gather(push, feel, unit, d)
    joined = _gather(joints, joints, unit, 1)
    nc, nj = len(contacts.front), len(joined.front)
    length = np.ones(nj)
    for j in range(nj):
        square = 0.0
        for a in range(joined.start[j], joined.start[j + 1]):
            square += joined.feel[a, 0] ** 2
        if square > 0:
            length[j] = np.sqrt(square)
        for a in range(joined.start[j], joined.start[j + 1]):
            joined.feel[a, 0] /= length[j]
            joined.push[a, 0] = joined.feel[a, 0]
    # The elements one after another: contacts, joints, rows of the mass matrix with more than their diagonal.
    ptr, col, val = mass
    start = np.empty(nc + nj + n + 1, np.int64)
    member = np.empty(len(contacts.column) + len(joined.column) + len(col), np.int64)
    start[: nc + 1] = contacts.start
    start[nc : nc + nj + 1] = contacts.start[nc] + joined.start
    end, at = start[nc + nj], nc + nj
    member[: start[nc]] = contacts.column
    member[start[nc] : end] = joined.column
    for i in range(n):
        if ptr[i + 1] - ptr[i] > 1:
            for k in range(ptr[i], ptr[i + 1]):
                member[end] = col[k]
                end += 1
            at += 1
            start[at] = end
    fronts, place, home = analyse(start[: at + 1], member[:end], n)
    contacts.front[:], joined.front[:] = home[:nc], home[nc : nc + nj]
    _settle(contacts, fronts, place)
    _settle(joined, fronts, place)
    entries = len(col)
    for j in range(nj):
        entries += (joined.start[j + 1] - joined.start[j]) ** 2
    slot, constant, at = np.empty(entries, np.int64), np.empty(entries), 0
    for i in range(n):
        for k in range(ptr[i], ptr[i + 1]):
            f = fronts.owner[min(place[i], place[col[k]])]
            slot[at] = _slot(fronts, f, find(fronts, f, place[i]), find(fronts, f, place[col[k]]))
            constant[at] = val[k] * unit[i] * unit[col[k]] * ratio
            at += 1
    for j in range(nj):
        for a in range(joined.start[j], joined.start[j + 1]):
            for b in range(joined.start[j], joined.start[j + 1]):
                slot[at] = _slot(fronts, joined.front[j], joined.place[a], joined.place[b])
                constant[at] = joined.feel[a, 0] * joined.feel[b, 0] / JOINT_SOFTNESS
                at += 1
    return fronts, place, contacts, joined, length, slot, constant


@njit(cache=True)
def _gather(push: Rows, feel: Rows, unit: Array, d: int) -> Elements:
    """Blocks of d rows of push and feel as elements, columns times unit; not yet placed."""
    push_ptr, push_col, push_val = push
    feel_ptr, feel_col, feel_val = feel
    count, room = (len(push_ptr) - 1) // d, len(push_col) + len(feel_col)
    start, column = np.zeros(count + 1, np.int64), np.empty(room, np.uint32)
    pushing, feeling = np.zeros((room, d)), np.zeros((room, d))
    entry = np.full(len(unit), -1)
    end = 0
    for e in range(count):
        for i in range(d):
            for k in range(push_ptr[e * d + i], push_ptr[e * d + i + 1]):
                v = push_col[k]
                if entry[v] < start[e]:
                    entry[v], column[end] = end, v
                    end += 1
                pushing[entry[v], i] = push_val[k] * unit[v]
            for k in range(feel_ptr[e * d + i], feel_ptr[e * d + i + 1]):
                v = feel_col[k]
                if entry[v] < start[e]:
                    entry[v], column[end] = end, v
                    end += 1
                feeling[entry[v], i] = feel_val[k] * unit[v]
        start[e + 1] = end
    front, place = np.zeros(count, np.int64), np.zeros(end, np.uint32)
    return Elements(start, column[:end].copy(), pushing[:end].copy(), feeling[:end].copy(), front, place)


@njit(cache=True)
def _settle(elements: Elements, fronts: Fronts, place: Index) -> None:
    """Renumber an element's variables by the order of elimination, and find them in its front."""
    for e in range(len(elements.front)):
        for a in range(elements.start[e], elements.start[e + 1]):
            elements.column[a] = place[elements.column[a]]
            elements.place[a] = find(fronts, elements.front[e], elements.column[a])


@njit(cache=True)
def _slot(fronts: Fronts, front: int, row: int, column: int) -> int:
    return int(fronts.start[front] + row * (fronts.first[front + 1] - fronts.first[front]) + column)


@njit(cache=True)
def _reorder(inverse: Rows, place: Index, unit: Array, ratio: float) -> tuple[Array, Index, Index]:
    """The inverse of the mass matrix in the system's units and order."""
    ptr, col, val = inverse
    n = len(place)
    row = np.empty(n, np.int64)
    for i in range(n):
        row[place[i]] = i
    value, index, start, at = np.empty(len(val)), np.empty(len(val), np.int64), np.zeros(n + 1, np.int64), 0
    for i in range(n):
        for k in range(ptr[row[i]], ptr[row[i] + 1]):
            value[at], index[at] = val[k] / (unit[row[i]] * unit[col[k]] * ratio), place[col[k]]
            at += 1
        start[i + 1] = at
    return value, index, start
