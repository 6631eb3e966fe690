"""The form of contact-wise methods: each contact reads its velocity from a state x, which its impulse changes.

    u_i = offset_i + G_i x,        x = rest + sum_i R_i r_i,        G R = W.

For a mechanical problem x holds the velocities of the bodies, G = J and R = M^-1 J'. A contact involves its two bodies only, so
that a sweep over all contacts costs O(nc) operations and bytes, and W is never formed. With joints, or if only W is known, x
holds the impulses themselves, G = W and R = I.

G and R are stored alike: contact i reads the columns read_column[read_start[i]:read_start[i+1]], with d coefficients in each.

In single precision (`single`) all these numbers are float32, and so are x, the impulses and the velocities. Only scalars of one
contact's law, or of a whole step, are double, as their literals are.
"""

from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.packed import Q, known_blocks, law_of, mechanical, mechanics_of
from frictionbench.problems.rows import Index32, normal_first
from frictionbench.solvers.interface import impulses

SINGLE_ROUNDING = 3e-7  # rounding error of a residual in single precision, as observed on steps of robots


class ContactForm(NamedTuple):
    """G (read) and R (push), stored with d coefficients for each entry; nc contacts of dimension d, nx states.

    read_start, push_start: (nc+1,). read_column, push_column: (entries,). read, push: (entries, d).
    offset: (nc, d) and rest: (nx,). block: (nc, d, d), each contact's own block of W.
    friction, friction_bias, scale, units: (nc,), those of the problem and of its residual.
    """

    read_start: Index32
    read_column: Index32
    read: Array
    push_start: Index32
    push_column: Index32
    push: Array
    offset: Array
    rest: Array
    block: Array
    friction: Array
    friction_bias: Array
    scale: Array
    units: Array


def contact_form(problem: FrictionProblem, relaxed: bool = False, precision: str = "double") -> ContactForm:
    """The form of a problem or of its convex relaxation; the state holds velocities if the problem has masses and no joints.

    precision: of the numbers, double or single.
    """
    units = problem.relaxation_units if relaxed else problem.units
    law = problem.friction, problem.friction_bias, problem.scale, units
    if not problem.mechanical or len(problem.joint_bias):
        parts = _pack_impulses(*problem.blocks, problem.q.reshape(-1, problem.dimension), *law)
    else:
        parts = _pack_velocities(*problem.contact_rows, *problem.inverse_rows, problem.free_velocity, problem.bias, *law)
    return ContactForm(*(map(single, parts) if precision == "single" else parts))


def single(part: Any) -> Any:
    """An array in single precision; arrays of indices are not changed."""
    return part.astype(np.float32) if part.dtype == np.float64 else part


def asked(form: ContactForm, tol: float) -> float:
    """The residual at which a method stops: in single precision tol less the error that rounding may cause, but not less than
    tol / 2."""
    return tol if form.offset.dtype == np.float64 else max(tol / 2, tol - SINGLE_ROUNDING)


def begin(form: ContactForm, start: Array | None) -> Array:
    """A checked copy of the impulses (nc, d) to start from, in the form's precision. Errors: InputError naming start."""
    return impulses(start, form.offset.shape).astype(form.offset.dtype, copy=False)


@part
def contact_form_of(packed, k):  # type: ignore[no-untyped-def]
    """The form of packed problem k."""
    law = law_of(packed, k)
    if mechanical(packed, k):
        start, column, J, m_start, m_column, m_value, free, bias = mechanics_of(packed, k)
        parts = _pack_velocities(start, column, J, m_start, m_column, m_value, free, bias, *law)
    else:
        first, neighbours, block = known_blocks(packed, k)
        q = packed.q[packed.first[k, Q] : packed.first[k + 1, Q]].reshape(len(law[0]), block.shape[1])
        parts = _pack_impulses(first, neighbours, block, q, *law)
    return ContactForm(*parts)


@kernel
def _pack_velocities(start, column, J, m_start, m_column, m_value, free, bias, mu, b_f, scale, units):  # type: ignore[no-untyped-def]
    """The entries of a ContactForm, with the velocities as the state."""
    nc, d, nv = len(bias), J.shape[1], len(free)
    start, column, read = normal_first(start, column, J)
    entries = 0
    for k in range(len(column)):
        entries += m_start[column[k] + 1] - m_start[column[k]]
    push_start, push_column, push = np.zeros(nc + 1, np.int32), np.empty(entries, np.int32), np.zeros((entries, d))
    block, offset, place = np.zeros((nc, d, d)), np.zeros((nc, d)), np.full(nv, -1, np.int32)
    at = 0
    for i in range(nc):
        offset[i, 0] = bias[i]
        for k in range(start[i], start[i + 1]):
            for m in range(m_start[column[k]], m_start[column[k] + 1]):
                v = m_column[m]
                if place[v] < push_start[i]:
                    push_column[at], place[v] = v, at
                    at += 1
        push_start[i + 1] = at
        for k in range(start[i], start[i + 1]):
            for m in range(m_start[column[k]], m_start[column[k] + 1]):
                for a in range(d):
                    push[place[m_column[m]], a] += m_value[m] * read[k, a]
        for k in range(start[i], start[i + 1]):
            if place[column[k]] >= push_start[i]:
                for a in range(d):
                    for b in range(d):
                        block[i, a, b] += read[k, a] * push[place[column[k]], b]
    law = mu.copy(), b_f.copy(), scale.copy(), units.copy()
    return start, column, read, push_start, push_column[:at], push[:at], offset, free.copy(), block, *law


@kernel
def _pack_impulses(first, neighbours, block, q, mu, b_f, scale, units):  # type: ignore[no-untyped-def]
    """The entries of a ContactForm, with the impulses as the state."""
    nc, d = q.shape
    start, push_start = np.empty(nc + 1, np.int32), np.empty(nc + 1, np.int32)
    column, read = np.empty(len(neighbours) * d, np.int32), np.empty((len(neighbours) * d, d))
    push_column, push, own_block = np.empty(nc * d, np.int32), np.zeros((nc * d, d)), np.zeros((nc, d, d))
    for i in range(nc + 1):
        start[i], push_start[i] = first[i] * d, i * d
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            for b in range(d):
                column[k * d + b] = neighbours[k] * d + b
                for a in range(d):
                    read[k * d + b, a] = block[k, a, b]
                    if neighbours[k] == i:
                        own_block[i, a, b] = block[k, a, b]
        for a in range(d):
            push_column[i * d + a], push[i * d + a, a] = i * d + a, 1.0
    law = mu.copy(), b_f.copy(), scale.copy(), units.copy()
    return start, column, read, push_start, push_column, push, q.copy(), np.zeros(nc * d), own_block, *law


@kernel
def state(form, r, x):  # type: ignore[no-untyped-def]
    """Compute x (nx,) from the impulses r (nc, d), free of the rounding errors that updates accumulate."""
    for v in range(len(x)):
        x[v] = form.rest[v]
    for i in range(len(r)):
        for k in range(form.push_start[i], form.push_start[i + 1]):
            pushed = 0.0
            for j in range(r.shape[1]):
                pushed += form.push[k, j] * r[i, j]
            x[form.push_column[k]] += pushed


@kernel
def velocity(form, x, u):  # type: ignore[no-untyped-def]
    """u (nc, d), the contact velocities of state x."""
    for i in range(len(u)):
        for j in range(u.shape[1]):
            u[i, j] = form.offset[i, j]
        for k in range(form.read_start[i], form.read_start[i + 1]):
            for j in range(u.shape[1]):
                u[i, j] += form.read[k, j] * x[form.read_column[k]]
