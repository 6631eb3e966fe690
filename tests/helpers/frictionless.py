"""Whether friction is at work in a problem, found independently of problems.analysis.frictionless: the frictionless velocities
by a quadratic program (Clarabel), the impulses that may belong to them by nonnegative least squares (SciPy)."""

import clarabel
import numpy as np
from scipy import sparse
from scipy.optimize import nnls

from frictionbench.problems import FrictionProblem

SLIDES = 1e-5  # of the largest free velocity: a contact that moves faster slides, or opens
NEEDED = 1e-4  # of the largest change of a velocity: what no frictionless impulses at resting contacts can explain


def friction_at_work(problem: FrictionProblem) -> bool:
    """Whether no frictionless answer satisfies Coulomb's law: whether contacts with friction that bear in all of them slide.

    The velocities v minimise (v - v*)'M(v - v*)/2 with N v + b >= 0 and F v + b_F = 0, and are unique. They satisfy the law iff
    M (v - v*) = N'r + F'lam with r >= 0 only at contacts that neither open nor, unless they are smooth, slide, and no contact
    slides that has a friction bias.
    """
    v = _velocities(problem)
    u = (problem.jacobian @ v).reshape(problem.contacts, -1)
    u[:, 0] += problem.bias
    unit = SLIDES * max(np.abs(problem.q).max(), np.abs(v).max())
    slides = np.linalg.norm(u[:, 1:], axis=1) > unit
    if (slides & (problem.friction_bias > 0)).any():
        return True
    bears = (np.abs(u[:, 0]) <= unit) & ~(slides & (problem.friction > 0))
    root = np.linalg.cholesky(problem.mass.toarray()).T
    change = root @ (v - problem.free_velocity)
    N, F = (np.linalg.solve(root.T, rows.T).T for rows in (problem.normal.toarray()[bears], problem.joints.toarray()))
    _, left = nnls(np.vstack([N, F, -F]).T, change) if len(N) + len(F) else (None, np.linalg.norm(change))
    return bool(left > NEEDED * np.abs(change).max(initial=0.0) and left > NEEDED * SLIDES)


def _velocities(problem: FrictionProblem) -> np.ndarray:
    """The frictionless velocities (nv,), in x = L' v with M = L L'."""
    root = np.linalg.cholesky(problem.mass.toarray()).T
    N, F = (sparse.csr_array(np.linalg.solve(root.T, rows.toarray().T).T) for rows in (problem.normal, problem.joints))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    cones = [clarabel.NonnegativeConeT(problem.contacts)]
    if F.shape[0]:
        cones.insert(0, clarabel.ZeroConeT(F.shape[0]))
    found = clarabel.DefaultSolver(
        sparse.csc_matrix(sparse.eye(len(root))),
        -root @ problem.free_velocity,
        sparse.csc_matrix(sparse.vstack([F, -N])),
        np.concatenate([-problem.joint_bias, problem.bias]),
        cones,
        settings,
    ).solve()
    return np.linalg.solve(root, np.array(found.x))
