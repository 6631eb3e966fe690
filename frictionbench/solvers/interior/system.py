"""A friction problem laid out for Newton's method in the velocities (solvers.interior.newton).

Contact velocities and impulses are scaled by one velocity and one impulse, velocities of bodies such that the mass matrix has a
unit diagonal. Variables are numbered in the order of elimination of solvers.sparse_lu.multifrontal; contacts and joints are
elements of its fronts. The mass matrix and the joints do not change from step to step and are a list of numbers to be added to
the fronts. If only the Delassus matrix W is known, contact velocities replace those of the bodies: M = I, J' = W on the left of
C and J = I on its right, so that an unsymmetric W is solved as given. (In the opposite arrangement, A = I + C W, the rows would
differ in size as much as sticking and open contacts, which misleads partial pivoting.)
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, lean, part
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.residual import largest
from frictionbench.problems.rows import Index32, Index64
from frictionbench.solvers.sparse_lu.multifrontal import Fronts, Place, analyse, place_of_entry, position_in_front

SOFTNESS = 1e-14  # delta, relative to a contact's mean diagonal of W: 1e-16 is lost in rounding, tall stacks fail with 1e-12
JOINT_SOFTNESS = 1e-8  # delta of a joint: larger than a contact's, because 1/delta is added to a mass matrix of size 1


class Elements(NamedTuple):
    """Constraints as elements of A: rows push and read (entries, d) on the variables column[start[e]:start[e+1]].

    u = read v and M dv = push' r; the two differ for a Delassus problem only. front: to which an element is added; place: the
    positions of its variables there.
    """

    start: Index64
    column: Place
    push: Array
    read: Array
    front: Index64
    place: Place


class System(NamedTuple):
    """A friction problem in units `speed`, the largest of its contacts, and `impulse`, with variables in order of elimination.

    slot, constant: the places in the fronts and the values of M + F'F/delta. inverse, indices, indptr: M^-1 by rows.
    shift: 0 for Coulomb's law, mu for its convex relaxation. weight: s_i of problems.residual.
    pairs: number of products of a contact (solvers.interior.point): 4 in the plane, 2 in space, 1 without any friction.
    acts: whether components of a contact's impulse act on anything (nc, d); the normal ones of a joint's dry friction do not.
    """

    fronts: Fronts
    contacts: Elements
    joints: Elements
    slot: Index64
    constant: Array
    inverse: Array
    indices: Index64
    indptr: Index64
    free_velocity: Array
    offset: Array
    joint_bias: Array
    friction: Array
    friction_bias: Array
    shift: Array
    weight: Array
    pairs: Index64
    acts: NDArray[np.bool_]
    speed: float
    impulse: float


# None in the plane, True in space: different types, so that only the branches of one are compiled.
Space = bool | None


def space_of(system: System) -> Space:
    return True if system.offset.shape[1] == 3 else None


class Units(NamedTuple):
    """The units of a system.

    speed, impulse: of the contacts' velocities and impulses. own: the unit of a body's velocity is speed * sqrt(own / M_ii).
    ratio: the factor of the mass matrix in these units.
    """

    speed: float
    impulse: float
    own: float
    ratio: float


def build_system(problem: FrictionProblem, relaxed: bool = False) -> System:
    """Scale a problem, or its convex relaxation, find the order of elimination and lay out its matrices."""
    units = units_of(problem.relaxation_units if relaxed else problem.units, problem.scale)
    contacts = problem.contact_rows if problem.mechanical else None
    if contacts is None:
        start, column, push, read = _delassus_elements(*problem.blocks, units.impulse / units.speed)
        units = units._replace(own=1.0, ratio=1.0)
    else:
        (start, column, push), read = contacts, contacts.value
    laws = problem.friction, problem.friction_bias, problem.scale, problem.offset
    motion = problem.free_velocity, *problem.mass_rows, *problem.inverse_rows
    joints = (*problem.joint_rows, problem.joint_bias)
    return system_of((start, column, push, read), laws, motion, joints, units, relaxed)


@kernel
def units_of(units, scale):  # type: ignore[no-untyped-def]
    """The Units: speed is the largest unit of the contacts, 1 if nothing moves, and impulse is speed over the geometric mean of
    s. Velocities of bodies are v = speed * unit * v^."""
    speed, total = largest(units), 0.0
    if speed == 0:
        speed = 1.0
    for s in scale:
        total += np.log(s)
    impulse = speed / np.exp(total / len(scale)) if len(scale) else speed
    return Units(speed, impulse, impulse / speed, speed / impulse)


@kernel
def system_of(contacts, laws, motion, joints, units, relaxed):  # type: ignore[no-untyped-def]
    """A System of contacts (start, column, push, read) with their laws (mu, b_f, s, offset), the free velocity, M and M^-1 by
    rows, and joints by rows with their bias."""
    free, m_start, m_column, m_value, i_start, i_column, i_value = motion
    f_start, f_column, f_value, joint_bias = joints
    unit = _units(m_start, m_column, m_value, units.own)
    elements, joined = (
        _gather(*contacts, unit),
        _gather(f_start, f_column, f_value.reshape(-1, 1), f_value.reshape(-1, 1), unit),
    )
    length = _normalise(joined)
    fronts, place = _find_fronts(elements, joined, m_start, m_column)
    slot, constant = _constants(fronts, place, joined, m_start, m_column, m_value, unit, units.ratio)
    value, index, begin = _reorder(i_start, i_column, i_value, place, unit, units.ratio)
    own_free, own_offset, mu, bias, shift, weight, pairs = _laws(*laws, free, place, unit, relaxed, units)
    own_joint_bias = np.empty(len(joint_bias))
    for j in range(len(own_joint_bias)):
        own_joint_bias[j] = joint_bias[j] / (length[j] * units.speed)
    return System(
        fronts, elements, joined, slot, constant, value, index, begin,
        own_free, own_offset, own_joint_bias, mu, bias, shift, weight, pairs, _acts(elements, mu, own_offset),
        units.speed, units.impulse,
    )  # fmt: skip


@part
def _laws(friction, friction_bias, scale, offset, free, place, unit, relaxed, units):  # type: ignore[no-untyped-def]
    """The vectors of the system, in its units."""
    nc, d = offset.shape
    own_free, own_offset, bias = np.empty(len(free)), np.empty((nc, d)), np.empty(nc)
    mu, shift, weight, pairs = np.empty(nc), np.zeros(nc), np.empty(nc), np.empty(nc, np.int64)
    for v in range(len(free)):
        own_free[place[v]] = free[v] / (unit[v] * units.speed)
    for i in range(nc):
        mu[i], bias[i], weight[i] = friction[i], friction_bias[i] / units.impulse, scale[i] * (units.impulse / units.speed)
        if relaxed:
            shift[i] = mu[i]
        has_friction = mu[i] > 0 or bias[i] > 0
        pairs[i] = (4 if d == 2 else 2) if has_friction else 1
        for a in range(d):
            own_offset[i, a] = offset[i, a] / units.speed
    return own_free, own_offset, mu, bias, shift, weight, pairs


@part
def _acts(elements, friction, offset):  # type: ignore[no-untyped-def]
    """Whether components of the impulses change a velocity, permit friction to do so or oppose a slip of their own (nc, d)."""
    acts = offset != 0
    for i in range(len(acts)):
        acts[i, 0] = False
        for a in range(elements.start[i], elements.start[i + 1]):
            for k in range(acts.shape[1]):
                acts[i, k] = acts[i, k] or elements.push[a, k] != 0
        for k in range(1, acts.shape[1]):
            acts[i, 0] = acts[i, 0] or (friction[i] > 0 and acts[i, k])
    return acts


@part
def _units(start, column, value, ratio):  # type: ignore[no-untyped-def]
    """The units (nv,) in which the mass matrix has a unit diagonal."""
    unit = np.empty(len(start) - 1)
    for i in range(len(unit)):
        unit[i] = 1.0
        for k in range(start[i], start[i + 1]):
            if column[k] == i:
                unit[i] = np.sqrt(ratio / value[k])
    return unit


def _delassus_elements(
    first: Index32, neighbours: Index32, block: Array, ratio: float
) -> tuple[Index32, Index32, Array, Array]:
    """The elements if only W is known: push = W' by contacts, times ratio, and read = I on the same columns."""
    nc, d = len(first) - 1, block.shape[1]
    order = np.argsort(neighbours, kind="stable")
    source = np.repeat(np.arange(nc), np.diff(first))[order]
    start = d * np.append(0, np.cumsum(np.bincount(neighbours, minlength=nc))).astype(np.int32)
    column = (d * source[:, None] + np.arange(d)).astype(np.int32).ravel()
    read = (source == neighbours[order])[:, None, None] * np.eye(d)
    return start, column, ratio * block[order].reshape(-1, d), read.reshape(-1, d)


@part
def _normalise(joined: Elements) -> Array:
    """Scale the joints' rows to length 1; return their former lengths, 1 for rows of zeros."""
    length = np.empty(len(joined.front))
    for j in range(len(length)):
        square = 0.0
        for a in range(joined.start[j], joined.start[j + 1]):
            square += joined.read[a, 0] ** 2
        length[j] = np.sqrt(square) if square > 0 else 1.0
        for a in range(joined.start[j], joined.start[j + 1]):
            joined.read[a, 0] /= length[j]
            joined.push[a, 0] = joined.read[a, 0]
    return length


@part
def _find_fronts(contacts, joined, m_start, m_column):  # type: ignore[no-untyped-def]
    """The fronts and the variables' places in the order of elimination; contacts and joints are placed in the fronts.

    The elements are the contacts, the joints and the rows of the mass matrix with off-diagonal entries.
    """
    n, nc, nj = len(m_start) - 1, len(contacts.front), len(joined.front)
    begin = np.empty(nc + nj + n + 1, np.int64)
    member = np.empty(len(contacts.column) + len(joined.column) + len(m_column), np.int64)
    for i in range(nc + 1):
        begin[i] = contacts.start[i]
    for j in range(nj + 1):
        begin[nc + j] = contacts.start[nc] + joined.start[j]
    for k in range(begin[nc]):
        member[k] = contacts.column[k]
    for k in range(begin[nc], begin[nc + nj]):
        member[k] = joined.column[k - begin[nc]]
    end, at = begin[nc + nj], nc + nj
    for i in range(n):
        if m_start[i + 1] - m_start[i] > 1:
            for k in range(m_start[i], m_start[i + 1]):
                member[end] = m_column[k]
                end += 1
            at += 1
            begin[at] = end
    fronts, place, home = analyse(begin[: at + 1], member[:end], n)
    _place_in_fronts(contacts, fronts, place, home[:nc])
    _place_in_fronts(joined, fronts, place, home[nc:])
    return fronts, place


@part
def _constants(fronts, place, joined, m_start, m_column, m_value, unit, ratio):  # type: ignore[no-untyped-def]
    """The contributions of the mass matrix and the joints to the fronts: slots and constants."""
    entries, at = len(m_column), 0
    for j in range(len(joined.front)):
        entries += (joined.start[j + 1] - joined.start[j]) ** 2
    slot, constant = np.empty(entries, np.int64), np.empty(entries)
    for i in range(len(unit)):
        for k in range(m_start[i], m_start[i + 1]):
            slot[at] = place_of_entry(fronts, place[i], place[m_column[k]])
            constant[at] = m_value[k] * unit[i] * unit[m_column[k]] * ratio
            at += 1
    for j in range(len(joined.front)):
        for a in range(joined.start[j], joined.start[j + 1]):
            for b in range(joined.start[j], joined.start[j + 1]):
                front = joined.front[j]
                width = fronts.first[front + 1] - fronts.first[front]
                slot[at] = fronts.start[front] + np.int64(joined.place[a]) * width + np.int64(joined.place[b])
                constant[at] = joined.read[a, 0] * joined.read[b, 0] / JOINT_SOFTNESS
                at += 1
    return slot, constant


@part
def _gather(start, column, push, read, unit):  # type: ignore[no-untyped-def]
    """Elements of contacts or joints, the columns of push and read multiplied by unit, not yet placed in the fronts.

    The columns of the first row come first, then those of the second, because the order of elimination follows them.
    """
    count, d, entries = len(start) - 1, push.shape[1], len(column)
    own_start, own_column, taken = np.zeros(count + 1, np.int64), np.empty(entries, np.uint32), np.zeros(entries, np.bool_)
    pushing, reading = np.empty((entries, d)), np.empty((entries, d))
    at = 0
    for e in range(count):
        for i in range(d):
            for k in range(start[e], start[e + 1]):
                if not taken[k] and (push[k, i] != 0 or read[k, i] != 0):
                    taken[k], own_column[at] = True, column[k]
                    for a in range(d):
                        pushing[at, a], reading[at, a] = push[k, a] * unit[column[k]], read[k, a] * unit[column[k]]
                    at += 1
        own_start[e + 1] = at
    return Elements(own_start, own_column[:at], pushing[:at], reading[:at], np.zeros(count, np.int64), np.zeros(at, np.uint32))


@lean
def _place_in_fronts(elements: Elements, fronts: Fronts, place: Index64, home: Index64) -> None:
    """Renumber the elements' variables in the order of elimination, and find their positions in the elements' fronts `home`."""
    for e in range(len(elements.front)):
        elements.front[e] = home[e]
        for a in range(elements.start[e], elements.start[e + 1]):
            column = elements.column[a]
            elements.column[a] = place[column]
            elements.place[a] = position_in_front(fronts, home[e], place[column])


@part
def _reorder(start, column, value, place, unit, ratio):  # type: ignore[no-untyped-def]
    """The inverse of the mass matrix in the system's units and order: values, columns, row starts."""
    n = len(place)
    row = np.empty(n, np.int64)
    for i in range(n):
        row[place[i]] = i
    own_value, own_column, begin, at = np.empty(len(value)), np.empty(len(value), np.int64), np.zeros(n + 1, np.int64), 0
    for i in range(n):
        for k in range(start[row[i]], start[row[i] + 1]):
            own_value[at] = value[k] / (unit[row[i]] * unit[column[k]] * ratio)
            own_column[at] = place[column[k]]
            at += 1
        begin[i + 1] = at
    return own_value, own_column, begin
