"""Independent coordinates or multipliers? A slider-crank in three angles and on three hinges."""

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import product
from time import perf_counter

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

import frictionbench as fb
from frictionbench.problems import SCHEMES, ReducedScene, simulation, start
from frictionbench.reports import GRID, Panel
from frictionbench.solvers import solve
from studies.motions import exact
from studies.study import Row, Study, Summary, Tables, order, require

SAME = 1e-9  # relative difference of matrices up to which they are the same
NAMES = {"angles": "slider_crank_angles", "hinges": "slider_crank"}
SOLVERS = ("lemke", "interior_point", "fischer_newton", "nsgs")


def drifts(
    schemes: Iterable[str] = ("anitescu_potra", "moreau", "stewart_trinkle"),
    counts: Iterable[int] = (100, 200, 400, 800),
    duration: float = 0.04,
) -> Iterator[Row]:
    """Drift off the hinges, distance from the motion by events, and time of a step, the two forms in turn."""
    known = fb.scene(NAMES["angles"], step=duration, duration=duration)
    assert isinstance(known, ReducedScene)
    end = known.place(SCHEMES["event_driven_newton"](known, start(known), exact).q)
    for scheme in schemes:
        for count in counts:
            for form, name in NAMES.items():
                made = fb.scene(name, step=duration / count, duration=duration)
                began = perf_counter()
                run = [step.q for step in simulation(made, exact, SCHEMES[scheme])]
                seconds = perf_counter() - began
                bodies = [made.place(q) for q in run] if isinstance(made, ReducedScene) else run
                full = fb.scene(NAMES["hinges"])
                yield {
                    "scheme": scheme,
                    "step": duration / count,  # s
                    "form": form,  # angles or hinges
                    "drift": max(float(np.abs(full.joints(q)[0]).max()) for q in bodies),  # the largest gap of a hinge, m
                    "error": float(np.abs(bodies[-1] - end).max()),  # of a body's coordinate at the end, m or rad
                    # of a step, with contact finding in Python; only to be compared between the forms
                    "seconds": seconds / count,
                }


def free(
    schemes: Iterable[str] = ("anitescu_potra", "moreau", "stewart_trinkle"),
    counts: Iterable[int] = (10, 20, 40, 80, 160),
    duration: float = 0.004,
) -> Iterator[Row]:
    """The same mechanism with so much clearance that nothing touches: the order of each scheme in each form."""
    known = fb.scene(NAMES["angles"], step=duration, duration=duration, clearance=0.01)
    assert isinstance(known, ReducedScene)
    end = known.place(SCHEMES["event_driven_newton"](known, start(known), exact).q)
    for scheme, count, (form, name) in product(schemes, counts, NAMES.items()):
        made = fb.scene(name, step=duration / count, duration=duration, clearance=0.01)
        *_, last = simulation(made, exact, SCHEMES[scheme])
        found = made.place(last.q) if isinstance(made, ReducedScene) else last.q
        yield {
            "scheme": scheme,
            "step": duration / count,  # s
            "form": form,  # angles or hinges
            "error": float(np.abs(found - end).max()),  # of a body's coordinate at the end, m or rad
        }


def problems(solvers: Iterable[str] = SOLVERS, steps: int = 200) -> Iterator[Row]:
    """The contact problems of a motion on hinges, and those in angles at the same states: W, q and the solvers' work."""
    full, reduced = (fb.scene(NAMES[form], clearance=0.001) for form in ("hinges", "angles"))
    assert isinstance(reduced, ReducedScene)
    pairs = []
    for step in simulation(reduced, exact, SCHEMES["anitescu_potra"], steps):
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
            "problems": len(pairs),  # contact problems, each in both forms
            "velocities_angles": sizes[0],  # velocities in angles
            "velocities_hinges": sizes[1],  # velocities on hinges
            "joints_hinges": len(pairs[0][1].joint_bias),  # joint equations on hinges
            "difference": apart,  # largest difference of the Delassus matrices, relative
            "work_angles": angles,  # sum of the work counters in angles
            "work_hinges": hinges,  # the same on hinges
        }


def summary(found: Tables) -> Summary:
    drifts, problems = found["drifts"], found["problems"]
    angles, hinges = (drifts[drifts["form"] == form] for form in ("angles", "hinges"))
    require(problems["difference"].max() < SAME, "both forms give the solvers the same Delassus matrices")
    require(angles["drift"].max() < 1e-12, "nothing drifts in angles")
    slopes = {scheme: order(rows["step"], rows["drift"]) for scheme, rows in hinges.groupby("scheme")}
    paired = angles.merge(hinges, on=["scheme", "step"], suffixes=("", "_hinges"))
    finer = paired[paired["step"] == paired["step"].min()]
    ratio = (paired["seconds"] / paired["seconds_hinges"]).quantile([0.25, 0.5, 0.75])
    first = problems.iloc[0]
    told = ", ".join(
        f"{scheme} {hinges[hinges['scheme'] == scheme]['drift'].min():.0e} m (order {slope})"
        for scheme, slope in slopes.items()
    )
    ends = ", ".join(
        f"{row.scheme} {row.error:.1e} in angles and {row.error_hinges:.1e} on hinges" for row in finer.itertuples()
    )
    counts = ", ".join(f"{row.solver} {row.work_angles} and {row.work_hinges}" for row in problems.itertuples())
    numbers = {
        "problems": first["problems"],
        "difference": f"{problems['difference'].max():.0e}",
        "drift": f"{hinges['drift'].max():.0e}",
        "velocities_angles": first["velocities_angles"],
        "velocities_hinges": first["velocities_hinges"],
        "joints": first["joints_hinges"],
        "drifts": told,
        "ends": ends,
        "counts": counts,
        "free": "; ".join(f"{form}: {_orders(rows)}" for form, rows in found["free"].groupby("form")),
        "time_middle": f"{ratio[0.5]:.2f}",
        "time_low": f"{ratio[0.25]:.2f}",
        "time_high": f"{ratio[0.75]:.2f}",
    }
    figures = {
        "drift": (Panel("drift", partial(_drift, hinges=hinges)), Panel("error", partial(_error, drifts=drifts))),
    }
    return Summary(numbers, figures)


def _orders(rows: pd.DataFrame) -> str:
    return ", ".join(f"{scheme} {order(own['step'], own['error'])}" for scheme, own in rows.groupby("scheme"))


def _drift(ax: Axes, hinges: pd.DataFrame) -> None:
    for scheme, rows in hinges.groupby("scheme"):
        ax.loglog(rows["step"], rows["drift"], "o-", ms=4, label=str(scheme))
    ax.set(xlabel="step, s", ylabel="gap of a hinge, m")
    ax.grid(**GRID)
    ax.legend()


def _error(ax: Axes, drifts: pd.DataFrame) -> None:
    for number, (scheme, rows) in enumerate(drifts.groupby("scheme")):
        for form, one in rows.groupby("form"):
            line = "o--" if form == "angles" else "o-"
            ax.loglog(one["step"], one["error"], line, color=f"C{number}", ms=4, label=f"{scheme}, {form}")
    ax.set(xlabel="step, s", ylabel="error at the end, m or rad")
    ax.grid(**GRID)
    ax.legend()


STUDY = Study((drifts, free, problems), summary)
