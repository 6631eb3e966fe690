"""The smooth path of one mode of contact up to its next event, by Dormand and Prince's method of order 8 with dense output.

The friction work and the impulses of the contacts are integrated with the state. After each step of the integrator the
conditions of the mode are evaluated on its dense output, and the first violation is located by Brent's method or bisection:

    touch      the gap of another contact closes
    lift       f_n < 0                  slip    |f_t| > mu f_n
    turn       t'v changes its sign     lost    the contact's features no longer face each other
    singular   det A changes its sign: beyond Painlevé's p = 0 no force is determined
    redundant  forces are not determined, and the friction problem's accelerations differ from the mode's

A force violates its condition when the acceleration that it would have to prevent exceeds VIOLATION_MARGIN times the
accelerations without contact forces, so the next mode is unambiguous. The impulse until then is proportional to the square.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from frictionbench.problems.check import Array
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.events.forces import accelerations
from frictionbench.problems.schemes.events.mode import Forces, Mode, forces
from frictionbench.problems.schemes.stepping import NoSolution, Smooth, Solve

SAMPLES = 6  # of the dense output in each step of the integrator, so that a touch and rebound within it are detected
VIOLATION_MARGIN = 1e-6  # see above
STILL = 1e-11  # relative to the fastest speed or the largest body: how far a speed or a gap may be on the wrong side of zero
RISES = 40  # halvings of an interval in the search for a time at which a condition holds
TIME_ACCURACY = 1e-14  # relative accuracy of an event's time
KINDS = ("touch", "lost", "singular", "redundant", "lift", "slip", "turn")


@dataclass(frozen=True, eq=False)
class Flight:
    """The state at the end of a smooth path, the event there, and the contacts' impulses and friction work along the path."""

    time: float
    q: Array
    v: Array
    event: str
    smooth: Smooth


class _Path:
    """One mode's equations and conditions; y = (q, v, friction work, impulses (nc, 2))."""

    def __init__(self, scene: Scene, mode: Mode, solve: Solve, start: Forces, size: float, speed: float) -> None:
        self.scene, self.mode, self.solve, self.start, self.size, self.speed = scene, mode, solve, start, size, speed
        self.nv, self.evaluations = len(scene.q0), 0
        self.features = set(map(tuple, mode.features.tolist()))

    def at(self, time: float, y: Array) -> tuple[Contacts, Contacts, Forces | None]:
        """The nearby contacts, those of the mode, and the mode's forces, or None if one of its contacts is missing."""
        self.evaluations += 1
        q, v = y[: self.nv], y[self.nv : 2 * self.nv]
        near = self.scene.contacts(q, self.scene.reach)
        contacts, complete = self.mode.find(near)
        return near, contacts, forces(self.scene, q, v, time, contacts, self.mode) if complete else None

    def slope(self, time: float, y: Array) -> Array:
        _, contacts, forces = self.at(time, y)
        v = y[self.nv : 2 * self.nv]
        if forces is None:
            return np.concatenate([v, np.zeros(len(y) - self.nv)])
        work = forces.tangential @ np.where(self.mode.slip, contacts.tangent_rows.dense(len(v)) @ v, 0.0)
        return np.concatenate([v, forces.a, [work], np.column_stack([forces.normal, forces.tangential]).ravel()])

    def conditions(self, time: float, y: Array) -> Array:
        """The values of the conditions, by KINDS and contact, which are at least -tolerance while the mode holds."""
        near, contacts, forces = self.at(time, y)
        others = [gap for gap, f in zip(near.gap, map(tuple, near.feature.tolist()), strict=True) if f not in self.features]
        touch, nc = min(others, default=self.scene.reach), len(self.mode.slip)
        if forces is None:
            return np.concatenate([[touch, -1.0, 1.0, 1.0], np.ones(3 * nc)])
        q, v = y[: self.nv], y[self.nv : 2 * self.nv]
        turn = np.where(self.mode.slip, self.mode.slip * (contacts.tangent_rows.dense(len(v)) @ v), 1.0)
        holds, lift, slip = 1.0, np.ones(nc), np.ones(nc)
        if forces.redundant:
            self.evaluations += 1
            posed = accelerations(self.scene, q, v, time, contacts, self.mode.slip, self.solve)
            holds = 1.0 if (np.abs(posed.contacts) <= VIOLATION_MARGIN * max(posed.size, self.size)).all() else -1.0
        else:
            lift = forces.normal * forces.stiffness[:, 0] + VIOLATION_MARGIN * self.size
            mu = self.scene.coefficients(contacts)
            spare = (mu * forces.normal - np.abs(forces.tangential)) * forces.stiffness[:, 1] + VIOLATION_MARGIN * self.size
            slip = np.where(self.mode.slip == 0, spare, 1.0)
        return np.concatenate([[touch, 1.0, forces.sign * self.start.sign, holds], lift, slip, turn])

    def tolerance(self) -> Array:
        nc = len(self.mode.slip)
        return np.concatenate([[STILL * self.scene.reach], np.zeros(3 + 2 * nc), np.full(nc, STILL * self.speed)])


def typical_speed(scene: Scene, q: Array, v: Array, time: float) -> float:
    """The fastest speed, but at least that of a fall from the height of the largest body."""
    pull = np.abs(scene.accelerate(q, scene.force(q, v, time))).max(initial=0.0)
    return float(max(scene.fastest(v), np.sqrt(pull * scene.reach)))


def fly(
    scene: Scene,
    q: Array,
    v: Array,
    time: float,
    end: float,
    mode: Mode,
    solve: Solve,
    size: float,
    speed: float,
    accuracy: float,
) -> Flight:
    """The path from here to the first event, or to the end. size, speed: of the contacts' accelerations and of the motion.
    accuracy: the relative tolerance of the integrator.

    Errors: NoSolution if the integrator's steps vanish or a singular mode is reached.
    """
    nv, nc = len(q), len(mode.slip)
    contacts, _ = mode.find(scene.contacts(q, 10 * scene.touch))
    path = _Path(scene, mode, solve, forces(scene, q, v, time, contacts, mode), size, speed)
    y = np.concatenate([q, v, np.zeros(1 + 2 * nc)])
    speed = speed + np.abs(path.start.a).max(initial=0.0) * (end - time) or 1.0
    push = speed * float(scene.mass_matrix(q).max())
    scale = np.repeat([scene.reach, speed, speed * push, push], [nv, nv, 1, 2 * nc])
    flight = DOP853(path.slope, time, y, end, rtol=accuracy, atol=accuracy * scale)
    event = ""
    while flight.status == "running" and not event:
        flight.step()
        if flight.status == "failed":
            raise NoSolution(f"forces grow beyond all bounds: the integrator's steps vanish at t = {flight.t:.6g} s")
        time, y, event = _first_violation(path, flight.t_old, flight.t, flight.dense_output(), flight.y)
    if event == "singular":
        places = mode.find(scene.contacts(y[:nv], scene.reach))[0].point[mode.slip != 0]
        where = ", ".join(f"({x:.4g}, {y:.4g})" for x, y in places)
        raise NoSolution(
            f"p vanishes at the contact sliding at {where}, at t = {time:.6g} s: no force is determined (Painlevé)"
        )
    smooth = Smooth(contacts, y[2 * nv + 1 :].reshape(-1, 2), float(y[2 * nv]), path.evaluations)
    return Flight(time, y[:nv], y[nv : 2 * nv], event, smooth)


def _first_violation(
    path: _Path, begin: float, end: float, dense: Callable[[float], Array], last: Array
) -> tuple[float, Array, str]:
    """The time, state and kind of the first event in a step of the integrator; the end and no kind if there is none."""
    before, known = begin, None
    for time in np.linspace(begin, end, SAMPLES + 1)[1:]:
        y = dense(time)
        values = path.conditions(time, y)
        violated = np.flatnonzero(values < -path.tolerance())
        if len(violated):
            known = path.conditions(before, dense(before)) if known is None else known
            located = [_locate(path, dense, int(i), before, time, known[i]) for i in violated]
            k = int(np.argmin(located))
            i, nc = int(violated[k]), len(path.mode.slip)
            return located[k], dense(located[k]), KINDS[i if i < 4 else 4 + (i - 4) // nc]
        before, known = float(time), values
    return end, last, ""


def _locate(path: _Path, dense: Callable[[float], Array], i: int, before: float, after: float, known: float) -> float:
    if i in (1, 2, 3):  # a condition that is only true or false: bisection
        for _ in range(40):
            middle = (before + after) / 2
            good = path.conditions(middle, dense(middle))[i] >= 0
            before, after = (middle, after) if good else (before, middle)
        return after

    def value(time: float, shift: float = 0.0) -> float:
        return float(path.conditions(time, dense(time))[i] + shift)

    shift, least = 0.0, path.tolerance()[i]
    if known <= least:  # it starts at its bound, as for a ball that has just bounced, and may rise and return
        risen = next((t for t in before + (after - before) * 0.5 ** np.arange(1, RISES) if value(t) > least), None)
        before, shift = (before, least) if risen is None else (float(risen), 0.0)
    if value(before, shift) <= 0:
        return after
    xtol = TIME_ACCURACY * max(abs(after), after - before)
    return float(brentq(value, before, after, args=(shift,), xtol=xtol, rtol=4 * np.finfo(float).eps))
