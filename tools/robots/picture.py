"""The picture of docs/robots.md: a humanoid that is let go, moved by `frictionbench.mujoco.step`, with its contact forces.

python -m tools.robots.picture docs/robots.svg
"""

import sys
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import frictionbench as fb
from tools.robots.models import MODELS, begin

TIMES, SPACING = (0.0, 0.3, 0.6, 0.9, 1.2), 1.2  # s, m between the figures
LONG = 1e-3  # m for a newton


def main(path: str) -> None:
    model = MODELS[0].load()
    data, drive = begin(model, "settle", 0)
    figure = Figure(figsize=(7.0, 2.4), layout="constrained")
    ax, h, result = figure.add_subplot(), model.opt.timestep, None
    frames = {round(time / h): i for i, time in enumerate(TIMES)}
    for k in range(max(frames) + 1):
        drive(data, k)
        result = fb.mujoco.step(model, data, before=result)
        if k in frames:
            _draw(ax, model, data, result, SPACING * frames[k])
            ax.text(SPACING * frames[k], -0.22, f"{k * h:.1f} s", ha="center", fontsize=8)
    ax.axhline(0, color="0.6", lw=0.8, zorder=0)
    ax.set_aspect("equal")
    ax.set_axis_off()
    with mpl.rc_context({"svg.hashsalt": "robots"}):
        figure.savefig(path, metadata={"Date": None})


def _draw(ax: Axes, model: Any, data: Any, result: fb.mujoco.Step, shift: float) -> None:
    """The bodies joined to their parents, seen from the side, and the normal forces."""
    for body in range(2, model.nbody):
        ends = data.xpos[[body, model.body_parentid[body]]]
        ax.plot(ends[:, 0] + shift, ends[:, 2], "-", color="#0077bb", lw=2.5, solid_capstyle="round")
    touching = [contact for contact in data.contact if contact.efc_address >= 0]
    for contact, impulse in zip(touching, result.impulse, strict=False):
        length = LONG * impulse[0] / model.opt.timestep
        x, z = contact.pos[0] + shift, contact.pos[2]
        ax.plot([x, x + length * contact.frame[0]], [z, z + length * contact.frame[2]], color="#e69f00", lw=1.5)


if __name__ == "__main__":
    main(sys.argv[1])
