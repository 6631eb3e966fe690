"""The scaled friction LCP together with velocities as unknowns, which makes M sparse: the mixed problem

    w = C v^ + R y + b,      0 = M^ (v^ - v*^) - B'y - F'l + d,      0 = F v^ + b_F,

where R are the rows and columns of the sliding speeds in the LCP. In space B = C and d = 0; in the plane, with the LCP of
solvers.outside.planar_lcp, C is N above T, B is N - mu T above T, and d = T'b_f. The velocities v^ = v root(M_ii) / theta and
the multipliers l of the joint equations are free. M^ has a unit diagonal, and the rows of F have length 1.
"""

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.outside.planar_lcp import smallest_lcp
from frictionbench.solvers.pivots.dense_lcp import DenseLCP

# An LCP of n unknowns, and M (N, N) and q (N,) of w = M z + q with N - n further unknowns, which are free and have w = 0.
Mixed = tuple[DenseLCP, Array, Array]


def mixed_lcp(problem: FrictionProblem | LCP, velocities: bool) -> Mixed:
    """Return the LCP alone, or with the velocities if this is asked for and the mechanics are known."""
    lcp = smallest_lcp(problem)
    if not velocities or isinstance(problem, LCP) or not problem.mechanical:
        return lcp, lcp.M, lcp.q
    nc, d, n, nv = problem.contacts, problem.dimension, len(lcp.q), len(problem.free_velocity)
    root, law, free, held = np.sqrt(problem.mass.diagonal()), slice(n - nc), slice(n, n + nv), slice(n + nv, None)
    rows = np.column_stack([problem.jacobian.toarray() / root, problem.offset.ravel(), problem.q]).reshape(nc, d, -1)
    rows = np.einsum("as,iaj->sij", np.eye(2) if d == 2 else lcp.scaled.basis, rows)
    rows = np.vstack([rows[0], *rows[1:].swapaxes(0, 1)])  # as problems.forms.lcp orders them
    if d == 2:
        theta, factor = lcp.scaled.form.theta, np.tile(lcp.scaled.form.E, 2)
    else:
        sizes = lcp.scaled.stretch * np.abs(np.concatenate([rows[:, -1], problem.friction_bias]))
        theta = np.sqrt(sizes.max(initial=0.0)) or 1.0  # that of solvers.pivots.scaled_lcp
        factor = lcp.scaled.stretch[law] / theta
    C, F = rows * factor[:, None], problem.joints.toarray() / root
    length = np.linalg.norm(F, axis=1)
    M, q = np.zeros((n + nv + len(F),) * 2), np.zeros(n + nv + len(F))
    M[:n, :n], M[law, law] = lcp.M, 0.0
    M[law, free], M[free, law] = C[:, :nv], -C[:, :nv].T
    M[free, free] = problem.mass.toarray() / np.outer(root, root)
    M[held, free], M[free, held] = F / length[:, None], -F.T / length
    q[law], q[n - nc : n] = C[:, nv] / theta, lcp.q[n - nc :]
    q[free], q[held] = -M[free, free] @ (problem.free_velocity * root) / theta, problem.joint_bias / length / theta
    if d == 2:
        M[free, :nc] += C[nc:, :nv].T * problem.friction
        q[free] += C[nc:, :nv].T @ lcp.scaled.bias
    return lcp, M, q
