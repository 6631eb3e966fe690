"""MuJoCo's mju_boxQP on the dual of the convex relaxation, in a child process: the only solver of MuJoCo that takes
matrices directly.

In the plane the cone's two edges generate every impulse, r = G z with G_i = [1 1; mu -mu] and z >= 0, so the relaxation is

    min  ½ z'(G'W G + 1e-12) z + (G'q)'z,     z >= 0,

where the small diagonal makes the matrix definite, as mju_boxQP requires, also for redundant contacts.

Licence: Apache-2.0.
Form: that program, dense and dimensionless. Setup: none. Solve: mju_boxQP, including the transfer of the matrix.
Clock: around mju_boxQP, in the child.
Tolerance: it takes none.
Flaws: it returns a rank and no measure of accuracy, and no accuracy can be requested: `frictionbench solve
    'stack[blocks=5,mass_ratio=1e6,push=1]' --solver mujoco_boxqp`.
Reference: Tassa, Mansard and Todorov 2014, "Control-limited differential dynamic programming".
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.children.child import child
from frictionbench.solvers.outside.scaled_delassus import ScaledDelassus, scaled_delassus


class Prepared(NamedTuple):
    given: ScaledDelassus
    generators: Array
    H: Array
    g: Array


@solver("mujoco_boxqp", family="outside", model="relaxation", needs=("mujoco",), lacks=("friction_bias",))
class BoxQP:
    """MuJoCo's mju_boxQP on the relaxation's dual, in a child process. (outside)

    Work: none is reported.
    """

    def form(self, problem: FrictionProblem) -> Prepared:
        given, nc = scaled_delassus(problem), problem.contacts
        G, i = np.zeros((2 * nc, 2 * nc)), np.arange(nc)
        G[2 * i, 2 * i] = G[2 * i, 2 * i + 1] = 1.0
        G[2 * i + 1, 2 * i], G[2 * i + 1, 2 * i + 1] = problem.friction, -problem.friction
        return Prepared(given, G, G.T @ (given.W @ G) + 1e-12 * np.eye(2 * nc), G.T @ given.q)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        given, G, H, g = prepared
        if not len(g):
            return Answer(np.zeros(given.contacts), Status.SOLVED)
        found = child("mujoco_rows.py").ask(H=H, g=g)
        status = Status.SOLVED if found["rank"] >= 0 else Status.FAILED
        return Answer(given.impulse(G @ found["z"]), status, detail=f"rank {found['rank']}", clock=found["clock"])
