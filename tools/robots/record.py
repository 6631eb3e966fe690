"""The recorded steps of the suite `robots`: a few of many candidates, chosen by their features and not by results of solvers.

The bodies are moved by MuJoCo's own step, with elliptic cones, so that no solver compared here influences the motion. Every
EVERY-th step in which constraints act is a candidate. The features of each model's candidates

    log(1 + .) of contacts, limits, dry friction, islands, redundant rows (loops of contacts, limits and equations);
    log10 of W's condition and of the ratio of effective masses; the share of loaded contacts that stick, by MuJoCo's forces

are divided by their standard deviation over all models' candidates, and k-means (seed 0) divides them into CLUSTERS clusters.
From each cluster the step nearest to the centre and the step farthest from it are taken, a typical and an unusual one. Steps
that need no friction, because the frictionless velocities satisfy Coulomb's law, are passed over. A model's share does not
depend on how often it has contacts. The problem stored is the one that `frictionbench.mujoco.step` would solve.

The selection (robots.tsv) is written before any problem with friction is solved. Then each step is solved by METHODS, and the
best answer is stored (robots.npz), together with the start that a simulation would have: the exact impulses of the previous
step, matched by geoms and joints.

    python -m tools.robots.record [select|answer]
"""

import csv
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import mujoco as mj
import numpy as np
from scipy.cluster.vq import kmeans2
from scipy.linalg import solve_triangular
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

import frictionbench as fb
from frictionbench.problems import idle
from tools.robots.models import MODELS, Array, begin

CLUSTERS, EVERY, STEPS = 4, 5, 500
FOLDER = Path(fb.__file__).parent
STORE = FOLDER / "problems" / "instances" / "steps" / "robots"
TABLE, ANSWERS = (FOLDER / "harness" / "plans" / f"robots.{suffix}" for suffix in ("tsv", "npz"))
# hybrid may use steps of the other two, so that agreement is independent only if nsgs is one of two methods.
METHODS = ("hybrid", "nsgs", "proximal_newton")
TOL, VERIFIED = 1e-10, 1e-8
FEATURES = ("contacts", "limits", "dry_friction", "islands", "redundancy", "condition", "mass_ratio", "sticking")
COLUMNS = ("case", "model", "behaviour", "step", "length", "velocities", "equations", *FEATURES, "hash", "verified", "apart")
WHOLE = mj.mjtState.mjSTATE_INTEGRATION
AT = mj.mjtConstraint
ROWS = (AT.mjCNSTR_LIMIT_JOINT, AT.mjCNSTR_LIMIT_TENDON), (AT.mjCNSTR_FRICTION_DOF, AT.mjCNSTR_FRICTION_TENDON)


class Candidate(NamedTuple):
    """A step of a motion. before, state: MuJoCo's states at the beginning of the previous step and of this one. facts: by the
    names of COLUMNS."""

    before: Array
    state: Array
    facts: dict[str, Any]


def candidates(name: str, model: Any, behaviours: tuple[str, ...]) -> Iterator[Candidate]:
    """Yield the candidates of all behaviours of a model."""
    model.opt.cone = mj.mjtCone.mjCONE_ELLIPTIC
    for seed, behaviour in enumerate(behaviours):
        data, drive = begin(model, behaviour, seed)
        state = np.empty(mj.mj_stateSize(model, WHOLE))
        for k in range(STEPS):
            drive(data, k)
            before = state.copy()
            mj.mj_getState(model, data, state, WHOLE)
            mj.mj_step(model, data)
            if data.warning[mj.mjtWarning.mjWARN_BADQACC].number:
                print(f"  {name} {behaviour}: MuJoCo's step diverges at {k}")
                break
            if k % EVERY == EVERY - 1 and data.efc_force.any():
                case = f"{name}-{behaviour}-{k:03}"
                named = {"case": case, "model": name, "behaviour": behaviour, "step": k, "length": model.opt.timestep}
                yield Candidate(before, state.copy(), named | _facts(model, data))


def _facts(model: Any, data: Any) -> dict[str, Any]:
    """Return the facts of a step. data: after MuJoCo's step, when constraints and forces still belong to the state before."""
    kind = data.efc_type
    J = np.array(data.efc_J).reshape(data.nefc, model.nv) if not mj.mj_isSparse(model) else _dense(model, data)
    mass = np.zeros((model.nv, model.nv))
    mj.mj_fullM(model, data, mass)
    root = np.linalg.cholesky(mass)
    A = solve_triangular(root, J.T, lower=True).T
    touching = [contact for contact in data.contact if contact.efc_address >= 0]
    blocks = [np.arange(one.efc_address, one.efc_address + min(one.dim, 3)) for one in touching]
    limits, dry = (np.flatnonzero((kind == a) | (kind == b)) for a, b in ROWS)
    blocks += [np.array([i]) for i in (*limits, *dry)]
    G = A[kind == AT.mjCNSTR_EQUALITY]
    owner = np.repeat(np.arange(len(blocks)), [len(block) for block in blocks])
    A = A[np.concatenate(blocks)] if blocks else A[:0]
    if len(G):
        A = A - (A @ np.linalg.pinv(G)) @ G
    scale = np.bincount(owner, (A**2).sum(axis=1)) / np.maximum(np.bincount(owner), 1)
    W = (A @ A.T) / np.sqrt(np.outer(scale[owner], scale[owner]))
    values = np.linalg.eigvalsh(W)
    rank = values > 1e-10 * values.max(initial=0)
    of_block = csr_array((np.ones(len(owner)), (np.arange(len(owner)), owner)), shape=(len(owner), len(blocks)))
    coupled = csr_array(of_block.T @ (np.abs(W) > 1e-10) @ of_block)
    forces = np.array([data.efc_force[block] for block in blocks[: len(touching)] if len(block) == 3]).reshape(-1, 3)
    mu = np.array([one.friction[0] for one in touching if one.dim >= 3])
    loaded = forces[:, 0] > 0
    sticks = loaded & (np.hypot(forces[:, 1], forces[:, 2]) < 0.99 * mu * forces[:, 0])
    return {
        "velocities": model.nv,
        "equations": len(G),
        "contacts": len(touching),
        "limits": len(limits),
        "dry_friction": len(dry),
        "islands": connected_components(coupled)[0],
        "redundancy": len(A) - int(rank.sum()),
        "condition": f"{values[-1] / values[rank][0]:.2e}" if rank.any() else "1",
        "mass_ratio": f"{scale.max() / scale.min():.2e}" if len(scale) else "1",
        "sticking": f"{sticks.sum() / max(loaded.sum(), 1):.2f}",
    }


def _dense(model: Any, data: Any) -> Array:
    ends = np.append(data.efc_J_rowadr, len(data.efc_J))
    return csr_array((data.efc_J, data.efc_J_colind, ends), shape=(data.nefc, model.nv)).toarray()


def chosen_of(model: Any, candidates: list[Candidate], deviation: Array) -> list[tuple[fb.FrictionProblem, Candidate]]:
    """Return the nearest and the farthest step of each cluster, among those that need friction."""
    points, data, chosen = _points(candidates) / deviation, mj.MjData(model), {}
    centres, label = kmeans2(points, CLUSTERS, minit="++", seed=0)
    distance = np.linalg.norm(points - centres[label], axis=1)
    for cluster in range(CLUSTERS):
        members = np.flatnonzero(label == cluster)
        order = members[np.argsort(distance[members], kind="stable")].tolist()
        for direction in (order, order[::-1]):
            for i in direction:
                mj.mj_setState(model, data, candidates[i].state, WHOLE)
                problem = fb.mujoco.problem(model, data)
                if problem.contacts and not idle(problem, _frictionless):
                    chosen[i] = problem
                    break
    return [(chosen[i], candidates[i]) for i in sorted(chosen)]


def _start(model: Any, one: Candidate) -> Array:
    """Return the exact impulses of the previous step, transferred to the contacts that this step shares with it."""
    data = mj.MjData(model)
    mj.mj_setState(model, data, one.before, WHOLE)
    before = fb.mujoco.step(model, data, "interior_point", tol=TOL)
    mj.mj_setState(model, data, one.state, WHOLE)
    fb.mujoco.problem(model, data)
    return fb.mujoco.start(model, data, before)


def _frictionless(problem: fb.FrictionProblem) -> Array:
    return fb.solve(problem, "interior_point", tol=1e-9).impulse


def _points(candidates: list[Candidate]) -> Array:
    table = np.array([[float(one.facts[name]) for name in FEATURES] for one in candidates])
    return np.hstack([np.log1p(table[:, :5]), np.log10(table[:, 5:7]), table[:, 7:]])


def select() -> None:
    """Write the steps and their table."""
    everything: dict[str, tuple[Any, list[Candidate]]] = {}
    for model in MODELS:
        loaded = model.load()
        everything[model.name] = loaded, list(candidates(model.name, loaded, model.behaviours))
        print(model.name, len(everything[model.name][1]), "candidates", flush=True)
    deviation = np.std(np.vstack([_points(found) for _, found in everything.values()]), axis=0)
    STORE.mkdir(exist_ok=True)
    for old in STORE.glob("*.npz"):
        old.unlink()
    rows, starts = [], {}
    for name, (loaded, found) in everything.items():
        for problem, one in chosen_of(loaded, found, np.maximum(deviation, 1e-9)):
            case = one.facts["case"]
            path, starts[f"{case} start"] = STORE / f"{case}.npz", _start(loaded, one)
            fb.save(problem, path)
            with np.load(path) as arrays:
                packed = dict(arrays)
            np.savez_compressed(path, allow_pickle=False, **packed)
            rows.append(one.facts | {"hash": problem.hash})
        print(name, len(rows), "steps", flush=True)
    _write(rows)
    np.savez_compressed(ANSWERS, allow_pickle=False, **starts)
    print(len(rows), "steps of", sum(len(found) for _, found in everything.values()), "candidates")


def answer() -> None:
    """Solve the steps of the table by all METHODS and store the best answer. The table lists the methods whose answers are
    verified, and the largest difference of their velocities over the largest change of a velocity."""
    with np.load(ANSWERS, allow_pickle=False) as arrays:
        kept = {name: arrays[name] for name in arrays if name.endswith(" start")}
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    for row in rows:
        problem = fb.instance("robot_step", case=row["case"])
        answers = {method: fb.solve(problem, method, tol=TOL).impulse for method in METHODS}
        left = {method: fb.residual(problem, impulse) for method, impulse in answers.items()}
        verified = [method for method in METHODS if left[method] <= VERIFIED]
        velocities = np.array([problem.velocity(answers[method]) for method in verified])
        change = np.abs(velocities - problem.free_velocity).max()
        kept[row["case"]] = answers[min(verified, key=lambda method: left[method])]
        row |= {"verified": ", ".join(verified), "apart": f"{np.ptp(velocities, axis=0).max() / change:.0e}"}
        if len(verified) < len(METHODS) or np.ptp(velocities, axis=0).max() > 1e-6 * change:
            print(row["case"], {method: f"{size:.0e}" for method, size in left.items()}, row["apart"], flush=True)
    np.savez_compressed(ANSWERS, allow_pickle=False, **kept)
    _write(rows)


def _write(rows: list[dict[str, Any]]) -> None:
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, delimiter="\t", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    for name in sys.argv[1:] or ("select", "answer"):
        {"select": select, "answer": answer}[name]()
