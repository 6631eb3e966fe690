"""Make docs/certified.tsv: which answers stored with the suite `hard` are certified, that is, proved to be near a solution.

    python -m tools.certify > docs/certified.tsv        needs python-flint

The problem's data are taken as exact double-precision numbers. The answer gives the mode of each contact. In this mode
Coulomb's law is a system of smooth equations

    v = v* + M^-1 (H'h + T't),      H v + b = 0,      t_i |u_i| + mu_i r_n,i u_i = 0 at every sliding contact i,

where H has the rows with zero velocity (normal rows of closed contacts, tangential rows of sticking ones, joints) and h their
impulses; T, t and u = T v are the tangential rows, impulses and velocities of sliding contacts. If rows of H with their offsets
b are dependent in exact arithmetic, a basis of them is kept. Then only as many entries of h are unknown, and the others have
values for which a linear program satisfies all limits strictly. For a problem given by W and q, these hold H M^-1 H' and H v*.

Newton's method finds the centre m of a box X in arithmetic of BITS bits. If the interval Newton operator m - F'(X)^-1 F(m) lies
in the interior of X, then X contains exactly one zero of F (Moore 1966, Rump 2010). If in addition, everywhere in X, r_n and
mu r_n - |r_t| of sticking contacts, r_n and |u_t| of sliding ones and u_n of open ones are positive, the zero is a solution. It
is the only one in X in this mode; solutions elsewhere are not excluded.

A line per answer has its family, scene, parameters, contacts, and the radius, the largest difference of a contact's velocity
between answer and solution over the contact's unit, or the reason why it is not certified.
"""

import json
import sys
from typing import Any, NamedTuple

import flint
import numpy as np
from flint import arb, arb_mat, fmpq, fmpq_mat
from numpy.typing import NDArray
from scipy.linalg import qr
from scipy.optimize import linprog
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

import frictionbench as fb
from frictionbench.harness.plans import hard
from frictionbench.problems import FrictionProblem, refined
from tools.admit import kept_answer

COLUMNS = ("family", "scene", "parameters", "contacts", "radius", "reason")
BITS = 400  # precision: a condition number of 1e60 leaves half of the digits
STEPS = 5  # Newton steps from an answer accurate to rounding: each doubles the number of digits
BOX = 2.0**-150  # radius of X over the largest unknown
ROOM = 1e-6  # over the largest impulse: less slack counts as none; ten times the linear program's tolerance
DEPENDENT_PIVOT = 1e-11  # relative pivot below which a row is treated as dependent, which exact arithmetic then checks
ZERO_SHARE = 1e-9  # relative to a contact's unit: smaller velocities and impulses are not distinguished from 0
MOST_UNKNOWNS = 400  # unknowns, which take some minutes: the cost grows as their cube

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Whole = NDArray[np.int64]


class NotCertifiedError(Exception):
    """The message says why."""


def mode_of(problem: FrictionProblem, r: Array, tie: float) -> tuple[Flags, Flags]:
    """Return which contacts (nc,) are closed, and which of these slide, as in the equations of Alart and Curnier.

    tie: contacts whose normal impulse and velocity are both within `tie` of zero, relative to the unit, count as closed,
    because other contacts may hold them closed. Errors: NotCertifiedError if the problem has a friction bias.
    """
    if problem.friction_bias.any():
        raise NotCertifiedError("a friction bias is at work")
    x, u = r * problem.scale[:, None], problem.contact_velocity(r)
    idle = np.maximum(np.abs(x[:, 0]), np.abs(u[:, 0])) <= tie * problem.units
    closed = idle | (x[:, 0] > u[:, 0])
    size, speed = (np.linalg.norm(each, axis=1) for each in (x[:, 1:] - u[:, 1:], u[:, 1:]))
    slides = (speed > ZERO_SHARE * problem.units) & (idle | (size > problem.friction * x[:, 0]))
    return closed, closed & (problem.friction > 0) & slides


class Rows(NamedTuple):
    """Rows of a problem in interval arithmetic. response (n, n): the velocity of each row for a unit impulse in each, arb.
    free (n,): velocities without impulses, arb. exact (n, nv + 1): the rows with their offsets, or None if only W and q are
    known."""

    response: arb_mat
    free: list[arb]
    exact: Array | None


def rows_of(problem: FrictionProblem, wanted: Whole) -> Rows:
    """Return the wanted rows, counted over the contacts (normal first) and then the joints."""
    d, nc = problem.dimension, problem.contacts
    if not problem.mechanical:
        W = problem.W.toarray()[np.ix_(wanted, wanted)]
        return Rows(arb_mat(W.tolist()), [arb(float(q)) for q in problem.q[wanted]], None)
    offset = np.zeros(nc * d)
    offset[::d] = problem.bias
    rows = np.vstack([problem.jacobian.toarray(), problem.joints.toarray()])[wanted]
    b = np.concatenate([offset, problem.joint_bias])[wanted]
    A = arb_mat(rows.tolist())
    push = _solved_by_blocks(problem.mass.toarray(), rows)  # M^-1 A'
    at_rest = A * arb_mat([[float(v)] for v in problem.free_velocity])
    return Rows(A * push, [at_rest[i, 0] + arb(float(b[i])) for i in range(len(b))], np.column_stack([rows, b]))


def _solved_by_blocks(mass: Array, rows: Array) -> arb_mat:
    """Return M^-1 rows', computed exactly by the diagonal blocks of M."""
    count, label = connected_components(csr_array(mass != 0))
    solution = np.zeros(rows.T.shape, dtype=object)
    for block in range(count):
        in_block = np.flatnonzero(label == block)
        used = np.flatnonzero(rows[:, in_block].any(axis=1))
        if not len(used):
            continue
        solved = _rational(mass[np.ix_(in_block, in_block)]).solve(_rational(rows[np.ix_(used, in_block)].T))
        for i, v in enumerate(in_block):
            for k, row in enumerate(used):
                solution[v, row] = arb(solved[i, k])
    return arb_mat(solution.tolist())


def _rational(matrix: Array) -> fmpq_mat:
    return fmpq_mat([[fmpq(*x.as_integer_ratio()) for x in line] for line in matrix.tolist()])


def certify(problem: FrictionProblem, impulse: Array) -> float:
    """Return the radius. Errors: NotCertifiedError with the reason."""
    flint.ctx.prec = BITS
    r = refined(problem, impulse)
    if r is None:
        raise NotCertifiedError("it cannot be refined to rounding")
    try:
        return _Certificate(problem, impulse, r, 0.0).radius()
    except NotCertifiedError:
        return _Certificate(problem, impulse, r, ZERO_SHARE).radius()


class _Certificate:
    """One problem in the mode of its refined impulses r, which `tie` decides. known: the answer.

    Errors of all methods: NotCertifiedError with the reason.
    """

    def __init__(self, problem: FrictionProblem, known: Array, r: Array, tie: float) -> None:
        self.problem, self.known, self.r, (self.closed, self.slide) = problem, known, r, mode_of(problem, r, tie)
        self.slides, d = np.flatnonzero(self.slide), problem.dimension
        closed, joints = np.flatnonzero(self.closed), np.arange(len(problem.joint_bias))
        stuck = np.flatnonzero(self.closed & ~self.slide & (problem.friction > 0))
        held = [closed * d, *(stuck * d + k for k in range(1, d)), problem.contacts * d + joints]
        self.zero, self.d = np.concatenate(held), d  # the rows with zero velocity
        self.active = np.concatenate([self.zero, *(self.slides * d + k for k in range(1, d))])  # and of sliding contacts
        if len(self.active) > MOST_UNKNOWNS:
            raise NotCertifiedError(f"too large: {len(self.active)} unknowns")
        self.rows = rows_of(problem, self.active)
        self.at = {int(row): k for k, row in enumerate(self.active)}  # row -> position among the active
        self.kept = self._basis()
        self.impulse = self._start()
        self.unknown = self._unknowns()

    def _basis(self) -> Whole:
        """Return the positions of linearly independent rows among the zero rows, on which the others depend exactly."""
        n = len(self.zero)
        if not n:
            return np.zeros(0, np.int64)
        W, root = self._scaled(n)
        independent = _pivots(W / root / root[:, None])
        if len(independent) < n:
            if self.rows.exact is None:
                raise NotCertifiedError("rows of W depend on each other, and what they follow from is not known")
            whole, part = _rational(self.rows.exact[:n]).rank(), len(independent)
            if whole > part:
                raise NotCertifiedError(f"{n - part} active rows depend on the others but for rounding")
        return independent

    def _scaled(self, n: int) -> tuple[Array, Array]:
        """Return W (n, n) of the first n active rows, and the square roots of its diagonal (n,)."""
        W = np.array([[float(self.rows.response[i, k]) for k in range(n)] for i in range(n)]).reshape(n, n)
        return W, np.sqrt(np.maximum(np.diag(W), np.finfo(float).tiny))

    def _unknowns(self) -> Whole:
        """Return the positions of the unknown impulses, which the kept rows determine; they are equal in number."""
        n = len(self.zero)
        if len(self.kept) == n:
            return self.kept
        effect = self._effect()[self.kept]
        effect[:, self.impulse[:n] == 0] = 0.0  # impulses that are zero stay exactly zero
        _, _, order = qr(effect, pivoting=True, mode="economic")
        return np.sort(order[: len(self.kept)])

    def _effect(self) -> Array:
        """Return the derivative of the active rows' velocities with respect to the zero rows' impulses, including the friction
        of sliding contacts. Both are scaled by the square roots of W's diagonal."""
        n, d = len(self.zero), self.d
        W, root = self._scaled(len(self.active))
        move = W[:, :n].copy()
        for i in map(int, self.slides):
            tangential = [self.at[i * d + k] for k in range(1, d)]
            move[:, self.at[i * d]] += np.asarray(W[:, tangential]) @ self._friction(i)
        return move / root[:, None] / root[:n]

    def _start(self) -> Array:
        """Return impulses of the active rows (n,): the refined ones, moved away from their limits if rows are dependent."""
        flat = np.concatenate([self.r.ravel(), np.zeros(len(self.problem.joint_bias))])
        if len(self.problem.joint_bias):
            flat[self.r.size :] = self._joint_impulses()
        start = flat[self.active]
        return start if len(self.kept) == len(self.zero) else self._with_room(start)

    def _joint_impulses(self) -> Array:
        """Return the joints' impulses for r: F M^-1 F' lam = -(F v + b_F) by least squares."""
        p = self.problem
        F, mass = p.joints.toarray(), p.mass.toarray()
        push = np.linalg.solve(mass, F.T)
        v = p.free_velocity + np.linalg.solve(mass, p.jacobian.T @ self.r.ravel())
        return np.asarray(np.linalg.lstsq(F @ push, -(F @ v + p.joint_bias), rcond=None)[0])

    def _friction(self, i: int) -> Array:
        """Return the friction (d - 1,) of a sliding contact for a normal impulse of 1."""
        slip = self.problem.contact_velocity(self.r)[i, 1:]
        return -float(self.problem.friction[i]) * slip / np.linalg.norm(slip)

    def _sizes(self, scaled: Array) -> Array:
        """Return for each zero row (n,) the largest scaled impulse of its island, for a joint the largest of all."""
        island = np.append(self.problem.islands, -1)[np.minimum(self.zero // self.d, self.problem.contacts)]
        sizes = np.full(len(scaled), np.abs(scaled).max(initial=0.0))
        for one in np.unique(island[island >= 0]):
            sizes[island == one] = np.abs(scaled[island == one]).max(initial=0.0)
        return np.where(sizes > 0, sizes, 1.0)

    def _with_room(self, start: Array) -> Array:
        """Return impulses with the same effect and the largest slack in all limits; in space pyramids replace the cones."""
        n, d, mu, kept, unit = len(self.zero), self.d, self.problem.friction, self.kept, np.eye(len(self.zero))
        closed = np.flatnonzero(self.closed)
        _, root = self._scaled(n)
        equal = self._effect()[kept]
        size = self._sizes(start[:n] * root[:n])
        equal = equal * size / size[kept][:, None]
        limits, right, of = [], [], []  # each: limit'dx + room of its contact <= right
        for c, i in enumerate(closed):
            normal = self.at[int(i * d)]
            limits.append(-unit[normal])
            right.append(start[normal] * root[normal] / size[normal])
            of.append(c)
            if not self.slide[i] and mu[i] > 0:
                tangential = [self.at[int(i * d + k)] for k in range(1, d)]
                for turn in np.array([[1.0], [-1.0]]) if d == 2 else _CORNERS:
                    limits.append(-mu[i] * unit[normal] + (turn * root[normal] / root[tangential]) @ unit[tangential])
                    right.append((mu[i] * start[normal] - float(turn @ start[tangential])) * root[normal] / size[normal])
                    of.append(c)
        above, below = np.array(limits), np.array(right)
        # First maximise each contact's slack, to find contacts that cannot be loaded; then the least slack of all others.
        room = _most_room(equal, above, below, np.eye(len(closed))[of], [], 100 * ROOM)
        free = room[n:] > ROOM
        still = [self.at[int(i * d + k)] for i in closed[~free] for k in range(d) if int(i * d + k) in self.at]
        held = np.array([c for c in range(len(of)) if free[of[c]]], dtype=int)
        start[still] = 0.0
        moved = start.copy()
        if len(held):
            common = np.ones((len(held), 1))
            room = _most_room(equal, above[held], below[held], common, [k for k in still if k < n], 1e3)
            if not room[n] > ROOM:
                raise NotCertifiedError("no impulses that satisfy all limits strictly are found")
            moved[:n] += room[:n] / root[:n] * size
        moved[still] = 0.0
        for one in map(int, self.slides):
            moved[[self.at[one * d + k] for k in range(1, d)]] = self._friction(one) * moved[self.at[one * d]]
        return moved

    def _velocities(self, impulse: list[arb]) -> list[arb]:
        """Return the velocities of the active rows."""
        pushed = self.rows.response * arb_mat([[x] for x in impulse])
        return [pushed[i, 0] + free for i, free in enumerate(self.rows.free)]

    def _equations(self, impulse: list[arb]) -> list[arb]:
        u = self._velocities(impulse)
        equations = [u[int(k)] for k in self.kept]
        for i in map(int, self.slides):
            tangential, along, _ = self._slip(i, u)
            pressed = arb(float(self.problem.friction[i])) * impulse[self.at[int(i * self.d)]]
            equations += [impulse[k] + pressed * each for k, each in zip(tangential, along, strict=True)]
        return equations

    def _slip(self, i: int, u: list[arb]) -> tuple[list[int], list[arb], arb]:
        """Return the positions of a contact's tangential rows, the direction of its slip, and its speed."""
        tangential = [self.at[i * self.d + k] for k in range(1, self.d)]
        if self.d == 2:
            return tangential, [arb(1) if u[tangential[0]].mid() > 0 else arb(-1)], abs(u[tangential[0]])
        speed = (u[tangential[0]] ** 2 + u[tangential[1]] ** 2).sqrt()
        return tangential, [u[k] / speed for k in tangential], speed

    def _derivative(self, impulse: list[arb]) -> arb_mat:
        u = self._velocities(impulse)
        W, columns = self.rows.response, [*map(int, self.unknown), *range(len(self.zero), len(self.active))]
        lines = [[W[int(k), c] for c in columns] for k in self.kept]
        where = {c: k for k, c in enumerate(columns)}
        for i in map(int, self.slides):
            tangential, along, speed = self._slip(i, u)
            mu, normal = arb(float(self.problem.friction[i])), self.at[int(i * self.d)]
            pressed = mu * impulse[normal]
            for k, each in enumerate(along):
                line = [arb(0)] * len(columns)
                if self.d == 3:
                    turn = [pressed * ((1 if m == k else 0) - each * along[m]) / speed for m in range(2)]
                    line = [turn[0] * W[tangential[0], c] + turn[1] * W[tangential[1], c] for c in columns]
                line[where[tangential[k]]] += 1
                if normal in where:
                    line[where[normal]] += mu * each
                lines.append(line)
        return arb_mat(lines)

    def radius(self) -> float:
        """Return the radius."""
        columns = [*map(int, self.unknown), *range(len(self.zero), len(self.active))]
        point = [arb(float(x)) for x in self.impulse]
        if columns:
            for _ in range(STEPS):
                step = self._newton(point, point)
                for k, c in enumerate(columns):
                    point[c] = (point[c] - step[k]).mid()
            size = max(abs(float(point[c])) for c in columns) or 1.0
            box = list(point)
            for c in columns:
                box[c] = arb(point[c], size * BOX)
            step = self._newton(point, box)
            inside = [point[c] - step[k] for k, c in enumerate(columns)]
            if not all(box[c].contains_interior(x) for c, x in zip(columns, inside, strict=True)):
                raise NotCertifiedError("the interval Newton operator does not map the box into itself")
            for c, x in zip(columns, inside, strict=True):
                point[c] = x
        self._require_strict(point)
        return self._distance(point)

    def _newton(self, point: list[arb], box: list[arb]) -> list[arb]:
        """Return F'(box)^-1 F(point)."""
        try:
            step = self._derivative(box).solve(arb_mat([[x] for x in self._equations(point)]))
        except ZeroDivisionError:
            raise NotCertifiedError("the equations of its mode are singular") from None
        return [step[k, 0] for k in range(step.nrows())]

    def _require_strict(self, impulse: list[arb]) -> None:
        """Check the strict inequalities. Errors: NotCertifiedError naming one that is not proved."""
        u, d, mu = self._velocities(impulse), self.d, self.problem.friction
        for i in map(int, np.flatnonzero(self.closed)):
            pressed = impulse[self.at[i * d]]
            if all(impulse[self.at[i * d + k]] == 0 for k in range(d) if i * d + k in self.at):
                continue  # its impulse and its u_n are exactly 0
            if not pressed > 0:
                raise NotCertifiedError(f"contact {i} is closed, with an impulse of 0 to {float(abs(pressed).upper()):.0e} N s")
            if self.slide[i]:
                if not self._slip(i, u)[2] > 0:
                    raise NotCertifiedError(f"contact {i} is between sticking and sliding")
            elif mu[i] > 0:
                friction = sum((impulse[self.at[i * d + k]] ** 2 for k in range(1, d)), arb(0)).sqrt()
                if not friction < arb(float(mu[i])) * pressed:
                    raise NotCertifiedError(f"contact {i} is between sticking and sliding")
        opened = np.flatnonzero(~self.closed)
        for other, speed in zip(opened, self._elsewhere(opened * d, impulse), strict=True):
            if not speed > 0:
                raise NotCertifiedError(f"contact {other} is between open and closed")

    def _elsewhere(self, others: Whole, impulse: list[arb]) -> list[arb]:
        """Return the velocities of any rows."""
        whole = rows_of(self.problem, np.concatenate([self.active, others]))
        n = len(self.active)
        padded = arb_mat([[x] for x in impulse] + [[arb(0)]] * len(others))
        pushed = whole.response * padded
        return [pushed[n + k, 0] + whole.free[n + k] for k in range(len(others))]

    def _distance(self, impulse: list[arb]) -> float:
        """Return the largest difference of a contact's velocity between answer and solution over the contact's unit."""
        p = self.problem
        exact = [float(x) for x in self._elsewhere(np.arange(p.contacts * self.d), impulse)]
        apart = np.abs(np.reshape(exact, (-1, self.d)) - p.contact_velocity(self.known)).max(axis=1)
        return float((apart / p.units).max())


_CORNERS = np.column_stack([np.cos(np.arange(16) * np.pi / 8), np.sin(np.arange(16) * np.pi / 8)]) / np.cos(np.pi / 16)


def _most_room(equal: Array, above: Array, below: Array, of: Array, still: list[int], most: float) -> Array:
    """Maximise the sum of the slacks `room` subject to above dx + of room <= below and equal dx = 0; return dx and room."""
    n, rooms = above.shape[1], of.shape[1]
    bounds = [(0.0, 0.0) if k in set(still) else (-1e3, 1e3) for k in range(n)] + [(0.0, most)] * rooms
    result = linprog(
        np.concatenate([np.zeros(n), -np.ones(rooms)]),
        A_ub=np.column_stack([above, of]),
        b_ub=np.maximum(below, 0.0),
        A_eq=np.column_stack([equal, np.zeros((len(equal), rooms))]),
        b_eq=np.zeros(len(equal)),
        bounds=bounds,
        method="highs",
    )
    if result.status != 0:
        raise NotCertifiedError("no impulses that satisfy all limits strictly are found")
    return np.asarray(result.x)


def _pivots(matrix: Array) -> Whole:
    """Return the indices of linearly independent rows of a symmetric matrix, in order."""
    _, R, order = qr(matrix, pivoting=True, mode="economic")
    size = np.abs(np.diag(R))
    return np.sort(order[: int((size > DEPENDENT_PIVOT * size.max(initial=0.0)).sum())])


def lines() -> Any:
    """Yield the lines of the table, the header first."""
    yield "\t".join(COLUMNS)
    for row in hard.table(hard.ADMITTED):
        known = kept_answer(row)
        radius, reason = "", ""
        try:
            if known is None:
                raise NotCertifiedError("a solution is known by theory alone")
            parameters = json.loads(row["parameters"])
            make = fb.instance if row["scene"] in fb.instances() else (lambda name, **p: fb.scene(name, **p).problem())
            radius = f"{certify(make(row['scene'], **parameters), known):.1e}"
        except NotCertifiedError as error:
            reason = str(error)
        yield "\t".join([row["family"], row["scene"], row["parameters"], row["contacts"], radius, reason])


if __name__ == "__main__":
    for line in lines():
        sys.stdout.write(line + "\n")
        sys.stdout.flush()
