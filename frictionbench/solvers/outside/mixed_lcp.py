"""The scaled friction LCP together with velocities as unknowns, which makes M sparse: the mixed problem

    w = C v^ + R y + b,      0 = M^ (v^ - v*^) - C'y - F'l,      0 = F v^ + b_F,

where R are the rows and columns of the sliding speeds in the LCP. The velocities v^ = v root(M_ii) / theta and the multipliers
l of the joint equations are free. M^ has a unit diagonal, and the rows of F have length 1.
"""

from typing import Any

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp

# An LCP of n unknowns, and M (N, N) and q (N,) of w = M z + q with N - n further unknowns, which are free and have w = 0.
Mixed = tuple[DenseLCP, Array, Array]


def mixed_lcp(problem: FrictionProblem | LCP, velocities: bool) -> Mixed:
    """Return the LCP alone, or with the velocities if this is asked for and the mechanics are known."""
    lcp = dense_lcp(problem)
    if not velocities or isinstance(problem, LCP) or not problem.mechanical:
        return lcp, lcp.M, lcp.q
    (nc, d), n, nv = lcp.scaled.contacts, len(lcp.q), len(problem.free_velocity)
    basis: Any = lcp.scaled.basis
    root, law, free, held = np.sqrt(problem.mass.diagonal()), slice(n - nc), slice(n, n + nv), slice(n + nv, None)
    rows = np.column_stack([problem.jacobian.toarray() / root, problem.offset.ravel(), problem.q])
    rows = np.einsum("as,iaj->sij", basis, rows.reshape(nc, d, -1))
    rows = np.vstack([rows[0], *rows[1:].swapaxes(0, 1)])  # as problems.forms.lcp orders them
    sizes = lcp.scaled.stretch * np.abs(np.concatenate([rows[:, -1], problem.friction_bias]))
    theta = np.sqrt(sizes.max(initial=0.0)) or 1.0  # that of solvers.pivots.scaled_lcp
    C, F = rows * (lcp.scaled.stretch[law] / theta)[:, None], problem.joints.toarray() / root
    length = np.linalg.norm(F, axis=1)
    M, q = np.zeros((n + nv + len(F),) * 2), np.zeros(n + nv + len(F))
    M[:n, :n], M[law, law] = lcp.M, 0.0
    M[law, free], M[free, law] = C[:, :nv], -C[:, :nv].T
    M[free, free] = problem.mass.toarray() / np.outer(root, root)
    M[held, free], M[free, held] = F / length[:, None], -F.T / length
    q[law], q[n - nc : n] = C[:, nv] / theta, lcp.q[n - nc :]
    q[free], q[held] = -M[free, free] @ (problem.free_velocity * root) / theta, problem.joint_bias / length / theta
    return lcp, M, q
