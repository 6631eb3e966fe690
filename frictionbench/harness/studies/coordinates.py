"""Independent coordinates or multipliers? A slider-crank in three angles and on three hinges."""

from collections.abc import Iterable, Iterator
from time import perf_counter

import numpy as np

from frictionbench.harness.studies.motions import exact
from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems.generalised import ReducedScene
from frictionbench.problems.scenes import scene
from frictionbench.problems.schemes import SCHEMES, start
from frictionbench.problems.simulate import simulate
from frictionbench.results.store import Row
from frictionbench.solvers import solve

NAMES = {"angles": "slider_crank_angles", "hinges": "slider_crank"}
SOLVERS = ("lemke", "interior_point", "fischer_newton", "nsgs")


def drifts(
    schemes: Iterable[str] = ("anitescu_potra", "moreau", "stewart_trinkle"),
    counts: Iterable[int] = (100, 200, 400, 800),
    duration: float = 0.04,
) -> Iterator[Row]:
    """Drift off the hinges, distance from the motion by events, and time of a step, the two forms in turn."""
    known = scene(NAMES["angles"], step=duration, duration=duration)
    assert isinstance(known, ReducedScene)
    end = known.place(SCHEMES["event_driven_newton"](known, start(known), exact).q)
    for scheme in schemes:
        for count in counts:
            for form, name in NAMES.items():
                made = scene(name, step=duration / count, duration=duration)
                began = perf_counter()
                run = [step.q for step in simulate(made, exact, SCHEMES[scheme])]
                seconds = perf_counter() - began
                bodies = [made.place(q) for q in run] if isinstance(made, ReducedScene) else run
                full = scene(NAMES["hinges"])
                yield {
                    "scheme": scheme,
                    "step": duration / count,
                    "form": form,
                    "drift": max(float(np.abs(full.joints(q)[0]).max()) for q in bodies),
                    "error": float(np.abs(bodies[-1] - end).max()),
                    "seconds": seconds / count,
                }


def problems(solvers: Iterable[str] = SOLVERS, steps: int = 200) -> Iterator[Row]:
    """The contact problems of a motion on hinges, and those in angles at the same states: W, q and the solvers' work."""
    full, reduced = (scene(NAMES[form], clearance=0.001) for form in ("hinges", "angles"))
    assert isinstance(reduced, ReducedScene)
    pairs = []
    for step in simulate(reduced, exact, SCHEMES["anitescu_potra"], steps):
        contacts = reduced.contacts(step.q, reduced.touch)
        if not len(contacts):
            continue
        in_angles = reduced.friction_problem(step.q, step.v, contacts)
        place = reduced.place(step.q)
        pairs.append((in_angles, full.friction_problem(place, reduced.slopes(step.q) @ step.v, full.contacts(place))))
    for name in solvers:
        work, apart = np.zeros(2), 0.0
        for pair in pairs:
            answers = [solve(problem, name, tol=1e-8) for problem in pair]
            work += [sum(answer.work.values()) for answer in answers]
            apart = max(apart, *(float(abs(a - b).max() / abs(b).max()) for a, b in [(pair[0].W, pair[1].W)]))
        angles, hinges = (int(number) for number in work)
        sizes = [len(problem.free_velocity) for problem in pairs[0]]
        yield {
            "solver": name,
            "problems": len(pairs),
            "velocities_angles": sizes[0],
            "velocities_hinges": sizes[1],
            "joints_hinges": len(pairs[0][1].joint_bias),
            "difference": apart,
            "work_angles": angles,
            "work_hinges": hinges,
        }


STUDY = Study(
    name="coordinates",
    question="Independent coordinates or multipliers?",
    method="""A slider-crank whose slider rattles in its guides is stepped in the three angles that its clearance leaves free,
    with a mass matrix that depends on them, and as three bodies on three hinges, whose forces are multipliers. Drift is the
    largest distance of a hinge's two points; the error at the end is taken from the motion by events. At states of the motion
    both forms' contact problems are compared as the solvers see them, by their Delassus matrices and their work counters.""",
    tables=(
        Table(
            drifts,
            {
                "scheme": "scheme",
                "step": "s",
                "form": "angles or hinges",
                "drift": "the largest gap of a hinge, m",
                "error": "of a body's coordinate at the end, m or rad",
                "seconds": "of a step, with contact finding in Python; only to be compared between the forms",
            },
        ),
        Table(
            problems,
            {
                "solver": "solver",
                "problems": "contact problems, each in both forms",
                "velocities_angles": "velocities in angles",
                "velocities_hinges": "velocities on hinges",
                "joints_hinges": "joint equations on hinges",
                "difference": "largest difference of the Delassus matrices, relative",
                "work_angles": "sum of the work counters in angles",
                "work_hinges": "the same on hinges",
            },
        ),
    ),
)
