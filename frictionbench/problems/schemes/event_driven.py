"""The event-driven scheme: smooth motion integrated with error control from event to event, and impacts at located times.

    M v' = k + J' f + F' lam,  q' = v      between events, in one mode of contact (problems.schemes.events.path)
    v+ = the answer of an impact           where a contact closes at a speed, by Poisson's or Newton's law of restitution

After each event the modes of the closed contacts follow from their accelerations, the solution of the friction problem of
forces (problems.schemes.events.forces). Its solver has to be exact up to rounding. A step of length scene.step has as many
events as occur; the results do not depend on its length. The energy changes by the work of friction, which is integrated too,
and in impacts.

A bounce that would not rise by LOW of the largest body ends a sequence of bounces: restitution is then zero, and the contact
stays closed. Where one contact alone bounces, on what pulls it back with an acceleration -a, the sequence accumulates at

    t + 2 v / (a (1 - e)),

v its speed after the impact at t, and the event `accumulation` tells that time: exact for the bouncing ball.

The scheme cannot go on, and says where and when, at a contact that slides where no force exists (Painlevé), where a force
grows beyond all bounds, and where MOST events do not reach the end of a step: impacts of several contacts accumulate.
Scenes are planar: it refuses those in space.

References: Pfeiffer and Glocker 1996; Génot and Brogliato 1999; Acary and Brogliato 2008, chapter 8.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.events.forces import accelerations, rates
from frictionbench.problems.schemes.events.mode import Mode, project
from frictionbench.problems.schemes.events.path import fly, typical_speed
from frictionbench.problems.schemes.impact import impact
from frictionbench.problems.schemes.stepping import Event, NoSolution, Scheme, Solve, Solved, Step, respond, scheme

ACCURACY = 1e-10  # of the integrator
CLOSED = 1e-9  # of the largest body: a gap at which a contact is closed, far above the error of a located event
LOW = 1e-9  # of the largest body: see above
AT_REST = 1e-9  # of the fastest speed: a normal or tangential speed that is none
SURE = 1e-8  # of the accelerations at hand: one that is none; far below events.path.MARGIN
MOST = 500  # smooth parts of a step, each with an event at its end: also touches that leave the motion as it is

Impact = Callable[[Scene, Array, Array, Contacts, Solve], tuple[list[Solved], Array]]


def newton(scene: Scene, q: Array, v: Array, contacts: Contacts, solve: Solve) -> tuple[list[Solved], Array]:
    """The impact by Newton's law, 0 <= n'v+ + e n'v ⟂ r_n >= 0; with friction it can add energy."""
    target = scene.restitutions(contacts) * np.minimum(contacts.normal @ v, 0.0)
    solved, v = respond("impact", scene.friction_problem(q, v, contacts, bias=target), contacts, solve)
    return [solved], v


def event_driven_scheme(name: str, law: Impact, accuracy: float = ACCURACY) -> Scheme:
    """The scheme with this law of impact and accuracy of the integrator, registered under `name`."""

    @scheme(name, events=True)
    def advance(scene: Scene, now: Step, solve: Solve) -> Step:
        return follow(scene, now, solve, law, accuracy)

    return advance


def follow(scene: Scene, now: Step, solve: Solve, law: Impact, accuracy: float) -> Step:
    """One step of length scene.step. Errors: NoSolution."""
    time, end, q, v = now.time, now.time + scene.step, now.q, now.v
    solved: list[Solved] = []
    smooth, events = [], []
    while True:
        contacts, speed = _closed(scene, q), typical_speed(scene, q, v, time)
        still = AT_REST * speed
        meeting = contacts.only(contacts.normal @ v <= still)
        if (meeting.normal @ v < -still).any():
            q, _ = project(scene, q, v, Mode(meeting.feature, np.ones(len(meeting), dtype=np.int64)))
            phases, after, kind, at = _impact(scene, q, v, time, meeting, solve, law)
            solved += phases
            events.append(Event(at, kind, v, after))
            v = after
        staying = contacts.only(np.abs(contacts.normal @ v) <= still)
        slip = _signs(staying.tangent @ v, still)
        found = accelerations(scene, q, v, time, staying, slip, solve)
        if len(staying):
            solved.append(found.solved)
        stays = found.contacts[:, 0] <= SURE * found.size
        starts = _signs(found.contacts[:, 1], SURE * found.size)
        mode = Mode(staying.feature[stays], np.where(slip, slip, starts)[stays])
        q, v = project(scene, q, v, mode)
        if end - time <= 1e-12 * scene.step:
            break
        flight = fly(scene, q, v, time, end, mode, solve, found.size, speed, accuracy)
        smooth.append(flight.smooth)
        time, q, v = flight.time, flight.q, flight.v
        if flight.event not in ("", "touch"):  # what touches has an impact, or leaves the motion as it is
            events.append(Event(time, flight.event, v, v))
        if len(smooth) > MOST:
            raise NoSolution(f"{MOST} events by t = {time:.9g} s: the events accumulate, and their limit is not known")
    return Step(end, q, v, _closed(scene, q), tuple(solved), tuple(smooth), tuple(events))


def _closed(scene: Scene, q: Array) -> Contacts:
    return scene.contacts(q, CLOSED * scene.reach)


def _signs(values: Array, least: float) -> NDArray[np.int64]:
    """Their signs; 0 for those up to `least`."""
    return np.where(np.abs(values) > least, np.sign(values), 0).astype(np.int64)


def _impact(
    scene: Scene, q: Array, v: Array, time: float, contacts: Contacts, solve: Solve, law: Impact
) -> tuple[list[Solved], Array, str, float]:
    """The phases, the velocity after, the kind of the event and its time."""
    solved, after = law(scene, q, v, contacts, solve)
    rebound = contacts.normal @ after
    back = rates(scene, q, after, contacts).normal + contacts.normal @ scene.accelerate(q, scene.force(q, after, time))
    e = scene.restitutions(contacts)
    low = (e > 0) & (e < 1) & (back < 0) & (rebound**2 <= 2 * np.abs(back) * LOW * scene.reach)
    if not (e > 0).any() or not low[e * rebound > 0].all():
        return solved, after, "impact", time
    inelastic, after = respond("impact", scene.friction_problem(q, v, contacts), contacts, solve)
    if len(contacts) > 1:
        return [inelastic], after, "impact", time
    return [inelastic], after, "accumulation", time + float(2 * rebound[0] / (-back[0] * (1 - e[0])))


event_driven = event_driven_scheme("event_driven", impact)
event_driven_newton = event_driven_scheme("event_driven_newton", newton)
