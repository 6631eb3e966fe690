"""What the measures of an answer must not depend on: units, the order of contacts, frames and mirrors, contacts met twice.

30 random problems, planar and spatial, with and without joints and friction biases; to each an exact answer and inexact ones.
"""

from functools import cache

import numpy as np
import pytest
from scipy import sparse

from frictionbench.harness.contract.check import mirrored, permuted, rotated
from frictionbench.problems.analysis.stability import backward_error
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import fclib_error, relaxation_residual, residual, residual_floor
from frictionbench.problems.verify import ledger_defect, verify
from frictionbench.solvers import Answer, Status, solve
from tests.helpers.friction_problems import spatial, with_joints

SEEDS = range(30)


@cache
def met(seed):
    """A problem and answers to it (nc, d): the best known, one off by 1e-6, and garbage."""
    random = np.random.default_rng(seed)
    if seed % 2:
        problem = spatial(seed, contacts=4, friction_bias=seed % 3 == 0, joints=2 * (seed % 5 == 0))
    else:
        problem = random_problem(seed, contacts=int(random.integers(1, 9)))
        if seed % 5 == 0:
            nv = len(problem.free_velocity)
            problem = with_joints(problem, random.standard_normal((min(2, nv - 1), nv)))
    best = solve(problem, "hybrid", tol=1e-12).impulse
    noise = random.standard_normal(best.shape) * np.linalg.norm(best, axis=1).max(initial=1e-3)
    return problem, (best, best + 1e-6 * noise, noise)


def energy(problem):
    return float(problem.free_velocity @ (problem.mass @ problem.free_velocity)) / 2


def measures(problem, r, units=True):
    """Each measure with what rounding may make of it; those that units change by nature only on request."""
    found = {
        "residual": residual(problem, r),
        "relaxation": relaxation_residual(problem, r),
        "backward": backward_error(problem, r),
        "energy": ledger_defect(problem, r) / energy(problem),
    }
    return found if units else found | {"FCLIB": fclib_error(problem, r)}


def assert_same(problem, r, other, moved, units=True):
    """Equal but for rounding, and judged alike; of the energy's terms r'u more of it is left."""
    floor = residual_floor(problem, r) + residual_floor(other, moved)
    of_energy = floor * problem.velocity_scale * np.abs(r).sum() / energy(problem)
    ours, theirs = measures(problem, r, units), measures(other, moved, units)
    for name, value in ours.items():
        if name == "backward" and not (value < 1 and theirs[name] < 1):
            continue  # rounding in r_t decides whether any change of mu would do
        slack = of_energy if name == "energy" else np.inf if name == "FCLIB" and value < 1e-9 else floor
        assert theirs[name] == pytest.approx(value, rel=1e-7, abs=max(10 * slack, 1e-15)), name
    for model in ("lcp", "relaxation"):
        verdicts = [verify(p, Answer(x, Status.SOLVED), model, 1e-5).verdict for p, x in ((problem, r), (other, moved))]
        assert verdicts[0] == verdicts[1]


def in_other_units(problem, speed, work, random):
    """Velocities in other units and of other coordinates, contact velocities times `speed`, energies times `work`."""
    unit = 10 ** random.uniform(-2, 2, len(problem.free_velocity))
    S, joint = sparse.diags_array(unit), 10 ** random.uniform(-2, 2)
    return problem.replace(
        mass=S @ problem.mass @ S * work,
        normal=problem.normal @ S * speed,
        tangent=problem.tangent @ S * speed,
        free_velocity=problem.free_velocity / unit,
        bias=problem.bias * speed,
        friction_bias=problem.friction_bias * work / speed,
        joints=problem.joints @ S * joint,
        joint_bias=problem.joint_bias * joint,
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_unit_invariance(seed):
    problem, answers = met(seed)
    random = np.random.default_rng(seed)
    for speed, work in ((1.0, 1e9), (1e3, 1.0), (10 ** random.uniform(-4, 4), 10 ** random.uniform(-9, 9))):
        other = in_other_units(problem, speed, work, random)
        for r in answers:
            assert_same(problem, r, other, r * work / speed)


@pytest.mark.parametrize("seed", SEEDS)
def test_contact_order_invariance(seed):
    problem, answers = met(seed)
    order = np.random.default_rng(seed).permutation(problem.contacts)
    for r in answers:
        assert_same(problem, r, permuted(problem, order), r[order], units=False)


@pytest.mark.parametrize("seed", SEEDS)
def test_frame_invariance(seed):
    """Each contact's tangents turned by an angle of its own, and all of them mirrored; in the plane mirrored alone."""
    problem, answers = met(seed)
    angle = np.random.default_rng(seed).uniform(0, 2 * np.pi, problem.contacts)
    other = mirrored(problem if problem.dimension == 2 else rotated(problem, angle))
    for r in answers:
        n, *t = r.T
        turned = (
            [-t[0]]
            if len(t) == 1
            else [-np.cos(angle) * t[0] - np.sin(angle) * t[1], np.cos(angle) * t[1] - np.sin(angle) * t[0]]
        )
        assert_same(problem, r, other, np.column_stack([n, *turned]), units=False)


@pytest.mark.parametrize("seed", [seed for seed in SEEDS if seed % 6 != 3])  # without friction biases
def test_duplicated_contact_invariance(seed):
    """The impulse of the second one is any part of the first one's; what is no solution stays as far from one."""
    problem, (best, off, garbage) = met(seed)
    i = seed % problem.contacts
    other = permuted(problem, np.array([*range(problem.contacts), i]))
    share = np.random.default_rng(seed).uniform()
    split = np.vstack([best, share * best[i]])
    split[i] *= 1 - share
    assert residual(other, split) <= 3 * residual(problem, best) + residual_floor(other, split)
    for r in (off, garbage):
        alone = np.vstack([r, 0 * r[:1]])
        assert residual(other, alone) >= residual(problem, r) * (1 - 1e-9) - residual_floor(problem, r)
