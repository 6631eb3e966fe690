"""The event-driven scheme: smooth motion integrated with error control from event to event, and impacts at located times.

    M v' = k + J' f + F' lam,  q' = v      between events, in one mode of contact (problems.schemes.events.path)
    v+ = the velocity after an impact      when a contact closes with a speed, by Poisson's or Newton's law of restitution

After each event the modes of the closed contacts follow from their accelerations, which solve the friction problem of forces
(problems.schemes.events.forces). The solver must be exact up to rounding. A step of length scene.step contains any number of
events; the results do not depend on its length. The energy changes only in impacts and by the work of friction, which is
integrated as well.

A bounce that would rise by less than LOW times the size of the largest body ends a sequence of bounces: its restitution is
zero, and the contact stays closed. If only one contact bounces, with a speed v after the impact at t and an acceleration -a
towards contact, the event `accumulation` has the time t + 2 v / (a (1 - e)), which is exact for the bouncing ball.

The scheme stops, and states where and when, if no force exists at a sliding contact (Painlevé), if a force grows without bound,
or if MOST_EVENTS do not reach the end of a step, because impacts of several contacts accumulate. It refuses spatial scenes.

References: Pfeiffer and Glocker 1996; Génot and Brogliato 1999; Acary and Brogliato 2008, chapter 8.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.events.forces import accelerations, rates
from frictionbench.problems.schemes.events.mode import Mode, project
from frictionbench.problems.schemes.events.path import fly, typical_speed
from frictionbench.problems.schemes.impact import impact
from frictionbench.problems.schemes.stepping import Event, NoSolution, Solve, Solved, Step, respond, scheme

ACCURACY = 1e-10  # relative tolerance of the integrator
CLOSED = 1e-9  # relative to the largest body: contacts with smaller gaps are closed; far above the error of a located event
LOW = 1e-9  # relative to the largest body: see above
REST_SPEED = 1e-9  # relative to the fastest speed: smaller normal or tangential speeds count as zero
SURE = 1e-8  # relative to the accelerations without contact forces: smaller ones count as zero; far below VIOLATION_MARGIN
MOST_EVENTS = 500  # smooth parts of a step, each ended by an event; touches that do not change the motion count as well

Impact = Callable[[Scene, Array, Array, Contacts, Solve], tuple[list[Solved], Array]]


def newton(scene: Scene, q: Array, v: Array, contacts: Contacts, solve: Solve) -> tuple[list[Solved], Array]:
    """The impact by Newton's law, 0 <= n'v+ + e n'v ⟂ r_n >= 0; with friction it can add energy."""
    target = scene.restitutions(contacts) * np.minimum(contacts.normal @ v, 0.0)
    solved, v = respond("impact", scene.friction_problem(q, v, contacts, bias=target), contacts, solve)
    return [solved], v


def follow(scene: Scene, now: Step, solve: Solve, law: Impact, accuracy: float = ACCURACY) -> Step:
    """One step of length scene.step. Errors: NoSolution."""
    time, end, q, v = now.time, now.time + scene.step, now.q, now.v
    solved: list[Solved] = []
    smooth, events = [], []
    while True:
        contacts, speed = scene.contacts(q, CLOSED * scene.reach), typical_speed(scene, q, v, time)
        still = REST_SPEED * speed
        meeting = contacts.only(contacts.normal @ v <= still)
        if (meeting.normal @ v < -still).any():
            q, _ = project(scene, q, v, Mode(meeting.feature, np.ones(len(meeting), dtype=np.int64)))
            phases, after, kind, at = _impact(scene, q, v, time, meeting, solve, law)
            solved += phases
            events.append(Event(at, kind, v, after))
            v = after
        staying = contacts.only(np.abs(contacts.normal @ v) <= still)
        slip = _signs(staying.tangent @ v, still)
        accelerating = accelerations(scene, q, v, time, staying, slip, solve)
        if len(staying):
            solved.append(accelerating.solved)
        stays = accelerating.contacts[:, 0] <= SURE * accelerating.size
        starts = _signs(accelerating.contacts[:, 1], SURE * accelerating.size)
        mode = Mode(staying.feature[stays], np.where(slip, slip, starts)[stays])
        q, v = project(scene, q, v, mode)
        if end - time <= 1e-12 * scene.step:
            break
        flight = fly(scene, q, v, time, end, mode, solve, accelerating.size, speed, accuracy)
        smooth.append(flight.smooth)
        time, q, v = flight.time, flight.q, flight.v
        if flight.event in ("", "slip", "turn"):  # its contacts are closed up to there, to the integrator's accuracy
            q, v = project(scene, q, v, mode)
        if flight.event not in ("", "touch"):  # a touch causes an impact or does not change the motion
            events.append(Event(time, flight.event, v, v))
        if len(smooth) > MOST_EVENTS:
            raise NoSolution(f"{MOST_EVENTS} events by t = {time:.9g} s: the events accumulate, and their limit is not known")
    return Step(end, q, v, scene.contacts(q, CLOSED * scene.reach), tuple(solved), tuple(smooth), tuple(events))


def _signs(values: Array, least: float) -> NDArray[np.int64]:
    """The signs of the values; 0 for magnitudes up to `least`."""
    return np.where(np.abs(values) > least, np.sign(values), 0).astype(np.int64)


def _impact(
    scene: Scene, q: Array, v: Array, time: float, contacts: Contacts, solve: Solve, law: Impact
) -> tuple[list[Solved], Array, str, float]:
    """The phases of the impact, the velocity after it, and the kind and time of the event."""
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


scheme("event_driven", events=True)(partial(follow, law=impact))
scheme("event_driven_newton", events=True)(partial(follow, law=newton))
