"""The study of compliant contact: its error and work against stiffness, and what it decides."""

from functools import partial

import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ALARM, GRID
from frictionbench.reports.studies.account import Account, Figure
from frictionbench.reports.studies.numbers import listing, order
from frictionbench.results.studies import StudyTables


def account(found: StudyTables) -> Account:
    table, pressed, stuck = (found[name] for name in ("stiffnesses", "indentations", "inconsistent"))
    radau = table[table["method"] == "Radau"]
    slopes = {name: order(rows["stiffness"], rows["error"]) for name, rows in radau.groupby("scene")}
    stiffest = radau[radau["stiffness"] == radau["stiffness"].max()]
    dear = (stiffest["work"] / stiffest["rigid_work"]).agg(["min", "max"])
    slower = (stiffest["time"] / stiffest["rigid_time"]).agg(["min", "max"])
    less, more = pressed[pressed["share"] < 1], pressed[pressed["share"] > 1]
    found.require(((less["spin"] - 4).abs() < 0.5).all(), "springs pressed less than the closed solution's let the rod lift")
    found.require(((more["spin"] - 4).abs() > 0.5).all(), "springs pressed more than that throw the rod")
    off = (stuck["impulse"] / stuck["rigid"] - 1).abs()
    last = stuck.iloc[-1]
    told = ", ".join(
        f"{name.replace('_', ' ')} {rows['error'].min():.0e} (order {slopes[name]})" for name, rows in radau.groupby("scene")
    )
    return Account(
        answer=f"Rigid where it has one answer: at k = {radau['stiffness'].max():.0e} N/m springs need {dear['min']:.2g} to "
        f"{dear['max']:.2g} times the evaluations of the rigid motion by events and {slower['min']:.2g} to "
        f"{slower['max']:.2g} times its time. Where the rigid model has two answers the springs' state decides, and where "
        "forces have none they give the rigid impulse.",
        result=f"Least distances from the rigid motion, of coordinates in m or rad, with orders in 1/k with Radau over "
        f"{radau['stiffness'].min():.0e} to {radau['stiffness'].max():.0e} N/m: "
        f"{_negated(told)}. Where p < 0 < K, Painlevé's rod lifts from springs pressed to "
        f"{listing([f'{x:g}' for x in less['share']])} "
        f"times the closed solution's force, and an impact changes its spin where they are pressed to "
        f"{listing([f'{x:g}' for x in more['share']])} times: the closed solution is an unstable equilibrium. Where no force "
        f"is a "
        f"solution, the tip stops after {last['stopped']:.1e} s at k = {last['stiffness']:.0e} N/m, by a normal "
        f"impulse "
        f"of {last['impulse']:.3f} N s; the rigid impulse is {last['rigid']:.3f} N s, and the difference falls from "
        f"{100 * off.iloc[0]:.1g} % to {100 * off.iloc[-1]:.1g} %. The springs then push on: {last['total']:.3f} N s in all.",
        limits="Springs and dampers are linear and friction has no memory: other laws of compliance have other limits. With "
        "joints "
        "on multipliers and in space nothing was integrated. Evaluations of the stiff integrators include those for Jacobians "
        "by "
        "differences. A restitution of zero is 0.01 here.",
        figures=(
            Figure(
                "stiffness",
                "Distance from the rigid motion, and evaluations of forces, against stiffness; crosses: BDF.",
                (
                    Panel("error", partial(_lines, table=table, column="error")),
                    Panel("work", partial(_lines, table=table, column="work")),
                ),
            ),
            Figure(
                "painleve",
                "Painlevé's rod where two forces are solutions: its spin after 2 ms against the springs' force at the start.",
                (Panel("the springs decide", partial(_decided, pressed=pressed)),),
                columns=1,
            ),
        ),
    )


def _negated(text: str) -> str:
    """Orders in 1/k: those in k with the other sign."""
    return text.replace("order -", "order ")


def _lines(ax: Axes, table: pd.DataFrame, column: str) -> None:
    for (name, method), rows in table.groupby(["scene", "method"]):
        look = {"marker": "o", "ls": "-"} if method == "Radau" else {"marker": "x", "ls": ":"}
        number = list(dict.fromkeys(table["scene"])).index(name)
        label = str(name).replace("_", " ") if method == "Radau" else None
        ax.loglog(rows["stiffness"], rows[column], color=f"C{number}", ms=4, label=label, **look)
    ax.set(xlabel="stiffness, N/m", ylabel="distance, m or rad" if column == "error" else "evaluations")
    ax.grid(**GRID)
    ax.legend()


def _decided(ax: Axes, pressed: pd.DataFrame) -> None:
    ax.plot(pressed["share"], pressed["spin"], "o-", color="#0077bb")
    ax.axvline(1.0, color=ALARM, ls="--", lw=0.8)
    ax.set(xlabel="force at the start over the closed solution's", ylabel="spin after 2 ms, rad/s")
    ax.grid(**GRID)
