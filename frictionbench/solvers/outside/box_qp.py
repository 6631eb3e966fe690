"""MuJoCo's mju_boxQP on the dual of the convex relaxation: the only solver of MuJoCo that takes matrices directly.

In the plane the cone's two edges generate every impulse, r = G z with G_i = [1 1; mu -mu] and z >= 0, so the relaxation is

    min  ½ z'(G'W G + 1e-13) z + (G'q)'z,     z >= 0,

where the small diagonal makes the matrix definite, as mju_boxQP requires, also for redundant contacts. W is its symmetric part.

Licence: Apache-2.0.
Form: that program, dense and dimensionless. Setup: none. Solve: mju_boxQP from z = 0.
Clock: around mju_boxQP.
Charged: some 30 µs more than a call by hand, 1.9 times at 2 contacts: the dimensionless form.
Settings: mju_boxQP stops after 100 iterations without saying so. default is one call; tuned calls it again from its own answer
    until that no longer changes, `frictionbench solve 'stack[blocks=50,friction=0.05,push=1]' --solver 'mujoco_boxqp' --solver
    'mujoco_boxqp[settings=tuned]'`.
Tolerance: it takes none.
Flaws: it returns a rank and no measure of accuracy, so that an answer after 100 iterations looks like any other: `frictionbench
    solve 'stack[blocks=50,friction=0.05,push=1]' --solver mujoco_boxqp`. The diagonal is felt with large mass ratios:
    `frictionbench solve 'stack[blocks=5,mass_ratio=1e8,push=1]' --solver mujoco_boxqp`.
Reference: Tassa, Mansard and Todorov 2014, "Control-limited differential dynamic programming".
"""

from importlib import import_module
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside.scaled_delassus import ScaledDelassus, scaled_delassus

_DEFINITE = 1e-13  # on a diagonal of about 1: the least with which the factorisation of redundant contacts succeeds

_CALLS = 20


class DualProgram(NamedTuple):
    """min ½ z'H z + g'z over z >= 0 (2 nc,), two generators a contact."""

    given: ScaledDelassus
    H: Array
    g: Array

    def answer(self, z: Array) -> Array:
        """The impulses (nc, 2) of z."""
        n, slip = z[0::2] + z[1::2], z[0::2] - z[1::2]
        return self.given.impulse(np.column_stack([n, self.given.friction * slip]).ravel())


def dual_program(problem: FrictionProblem, definite: float) -> DualProgram:
    """The relaxation's dual in the plane, with `definite` added to the diagonal."""
    given = scaled_delassus(problem, symmetric=True)
    return DualProgram(given, *_dual(given.W, given.q, given.friction, definite))


@solver(
    "mujoco_boxqp",
    family="outside",
    model="relaxation",
    needs=("mujoco",),
    lacks=("friction_bias", "asymmetry"),
    variants=("settings=default", "settings=tuned"),
)
class BoxQP:
    """MuJoCo's mju_boxQP on the relaxation's dual. (outside)

    settings: default or tuned. Work: calls.
    """

    settings: str = "default"

    def form(self, problem: FrictionProblem) -> DualProgram:
        return dual_program(problem, _DEFINITE)

    def solve(self, prepared: DualProgram, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        mujoco: Any = import_module("mujoco")
        n = len(prepared.g)
        if not n:
            return Answer(np.zeros(prepared.given.contacts), Status.SOLVED)
        z, factor, index = np.zeros((n, 1)), np.zeros((n, n + 7)), np.zeros((n, 1), dtype=np.int32)
        begun, calls, changed = perf_counter(), 0, True
        while changed and calls < (_CALLS if self.settings == "tuned" else 1):
            last, calls = z.copy(), calls + 1
            rank = int(mujoco.mju_boxQP(z, factor, index, prepared.H, prepared.g[:, None], np.zeros((n, 1)), None))
            changed = rank >= 0 and not np.array_equal(z, last)
        clock = perf_counter() - begun
        status = Status.SOLVED if rank >= 0 else Status.FAILED
        return Answer(prepared.answer(z.ravel()), status, {"calls": calls}, detail=f"rank {rank}", clock=clock)


@kernel
def _dual(W, q, mu, definite):  # type: ignore[no-untyped-def]
    """H and g."""
    nc = len(mu)
    H, g = np.empty((2 * nc, 2 * nc)), np.empty(2 * nc)
    for i in range(nc):
        for s in range(2):
            a = mu[i] if s == 0 else -mu[i]
            row = 2 * i + s
            g[row] = q[2 * i] + a * q[2 * i + 1]
            for j in range(nc):
                n = W[2 * i, 2 * j] + a * W[2 * i + 1, 2 * j]
                t = mu[j] * (W[2 * i, 2 * j + 1] + a * W[2 * i + 1, 2 * j + 1])
                H[row, 2 * j], H[row, 2 * j + 1] = n + t, n - t
            H[row, row] += definite
    return H, g
