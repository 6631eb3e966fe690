"""Operations of one contact, in the plane and in space: its rows applied to velocities, and the residual of its law.

Arguments and results are scalars, as these are the innermost loops of the interior point methods.
"""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, part
from frictionbench.problems.forms.cone import nearest
from frictionbench.solvers.interior.lorentz import Vector
from frictionbench.solvers.interior.system import Elements
from frictionbench.solvers.sparse_lu.multifrontal import Fronts


@part
def push_planar(contacts: Elements, i: int, normal: float, tangent: float, momentum: Array) -> None:
    """momentum += push' (normal, tangent) of contact i."""
    for a in range(contacts.start[i], contacts.start[i + 1]):
        momentum[contacts.column[a]] += contacts.push[a, 0] * normal + contacts.push[a, 1] * tangent


@inlined
def push_spatial(contacts: Elements, i: int, r: Vector, momentum: Array) -> None:
    """momentum += push' r of contact i."""
    for a in range(contacts.start[i], contacts.start[i + 1]):
        along = contacts.push[a, 0] * r[0] + contacts.push[a, 1] * r[1] + contacts.push[a, 2] * r[2]
        momentum[contacts.column[a]] += along


@part
def read_planar(contacts: Elements, i: int, v: Array) -> tuple[float, float]:
    """read v of contact i."""
    un = ut = 0.0
    for a in range(contacts.start[i], contacts.start[i + 1]):
        un += contacts.read[a, 0] * v[contacts.column[a]]
        ut += contacts.read[a, 1] * v[contacts.column[a]]
    return un, ut


@inlined
def read_spatial(contacts: Elements, i: int, v: Array) -> Vector:
    """read v of contact i."""
    u0 = u1 = u2 = 0.0
    for a in range(contacts.start[i], contacts.start[i + 1]):
        along = v[contacts.column[a]]
        u0 += contacts.read[a, 0] * along
        u1 += contacts.read[a, 1] * along
        u2 += contacts.read[a, 2] * along
    return u0, u1, u2


@part
def add_planar(contacts: Elements, i: int, nn: float, nt: float, tn: float, tt: float, fronts: Fronts, storage: Array) -> None:
    """Add push' C read of contact i, C = [[nn, nt], [tn, tt]], to its front."""
    f, lo, hi = contacts.front[i], contacts.start[i], contacts.start[i + 1]
    begin, width = fronts.start[f], fronts.first[f + 1] - fronts.first[f]
    for a in range(lo, hi):
        row = begin + contacts.place[a] * width
        normal = contacts.push[a, 0] * nn + contacts.push[a, 1] * tn
        tangent = contacts.push[a, 0] * nt + contacts.push[a, 1] * tt
        for b in range(lo, hi):
            storage[row + contacts.place[b]] += normal * contacts.read[b, 0] + tangent * contacts.read[b, 1]


@inlined
def add_spatial(contacts: Elements, i: int, n: Vector, s: Vector, t: Vector, fronts: Fronts, storage: Array) -> None:
    """Add push' C read of contact i, C by its rows n, s, t, to its front."""
    f, lo, hi = contacts.front[i], contacts.start[i], contacts.start[i + 1]
    begin, width = fronts.start[f], fronts.first[f + 1] - fronts.first[f]
    for a in range(lo, hi):
        row = begin + contacts.place[a] * width
        p0, p1, p2 = contacts.push[a, 0], contacts.push[a, 1], contacts.push[a, 2]
        c0, c1, c2 = p0 * n[0] + p1 * s[0] + p2 * t[0], p0 * n[1] + p1 * s[1] + p2 * t[1], p0 * n[2] + p1 * s[2] + p2 * t[2]
        for b in range(lo, hi):
            along = c0 * contacts.read[b, 0] + c1 * contacts.read[b, 1] + c2 * contacts.read[b, 2]
            storage[row + contacts.place[b]] += along


@part
def larger(a: float, b: float) -> float:
    """max(a, b) for a >= 0, infinity where b is not a number."""
    if b <= a:
        return a
    return b if b > a else np.inf


@part
def _norm(a: float, b: float) -> float:
    return np.sqrt(a * a + b * b) if b else abs(a)  # in the plane b is 0, and a root a good part of a contact's time


@part
def natural(r: Vector, u: Vector, mu: float, bias: float, shift: float, weight: float) -> float:
    """weight |r - P_K(r - (u + shift |u_t| e_n) / weight)| for one contact, and with a shift, for Coulomb's law, at least the
    defect of Signorini's (problems.residual)."""
    compliance = 1 / weight
    n = r[0] - (u[0] + shift * _norm(u[1], u[2])) * compliance
    t1, t2 = r[1] - u[1] * compliance, r[2] - u[2] * compliance
    normal, share = nearest(n, _norm(t1, t2), mu, bias)
    off, off1, off2 = r[0] - normal, r[1] - share * t1, r[2] - share * t2
    defect = weight * np.sqrt(off * off + off1 * off1 + off2 * off2)
    return larger(defect, abs(min(weight * r[0], u[0]))) if shift > 0 else defect
