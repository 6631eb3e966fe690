"""Judge the steps of an engine: residual and violated laws of its own impulses, then a run of solvers on the same problems.

The files are read and judged in workers. The problems that they are judged by are the sources of an ordinary run, which can be
interrupted and resumed.
"""

import json
from hashlib import sha256
from itertools import groupby
from pathlib import Path
from shutil import copyfile
from typing import Any

import numpy as np
from scipy.linalg import null_space

from frictionbench.harness.cells import worker
from frictionbench.harness.cells.reference import reference_answer
from frictionbench.harness.plans.plan import Plan, Plugin, Source
from frictionbench.harness.plans.recorded import natural
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import COLLECT_SECONDS, open_folder
from frictionbench.harness.workers.pool import Pool, Task, scratch_pool
from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.contradiction import contradiction
from frictionbench.problems.check import Array, require
from frictionbench.problems.measures import judged, penetration, violations
from frictionbench.problems.recorded import native
from frictionbench.problems.residual import contact_residuals, residual_floor
from frictionbench.problems.verify import ledger_defect
from frictionbench.results.files import parsed, replaced, subfolder
from frictionbench.results.judgement import FILE, LAWS, Judgement, NetImpulse, write_judgements
from frictionbench.solvers import find

FOLDER = "judged"
OUR_SOLVER = "hybrid"  # our solver of Coulomb's law for any problem, with which the engine is compared
STICKING_SLIP = 1e-6  # relative to a contact's unit of velocity: slower slip in the exact answer counts as none
RANK_TOL = 1e-9  # relative: smaller singular values count as zero
DIVERGED = 1e100  # N s: squares of larger impulses may overflow
MOST_FORCES = 200  # contacts whose forces are kept for a figure


def judge_file(folder: Path, path: Path) -> Judgement:
    """Judge the step in a file, and store the problem that it is judged by as folder/judged/HASH.npz.

    Errors: InputError naming the file, or the field in it that cannot be used.
    """
    step = native.load_step(path)
    problem, impulse = judged(step), step.impulse
    require(np.abs(impulse).max(initial=0.0) < DIVERGED, str(path), f"impulse: an entry of {DIVERGED:g} N s or more overflows")
    with replaced(subfolder(folder, FOLDER) / f"{problem.hash}.npz") as file:
        native.save(problem, file)
    by_contact, laws = contact_residuals(problem, impulse), violations(problem, impulse)
    largest = dict(zip(LAWS, (float(one.max(initial=0.0)) for one in laws), strict=True))
    law = LAWS[int(np.argmax([one[by_contact.argmax()] for one in laws]))] if problem.contacts else ""
    size, floor = float(by_contact.max(initial=0.0)), residual_floor(problem, impulse)
    reach = problem.velocity_size(impulse).max(initial=0.0)
    small = np.abs(problem.scale[:, None] * impulse).max(initial=0.0) <= RANK_TOL * reach
    unloaded = problem.mechanical and not len(problem.joint_bias) and small and size <= floor
    limit = problem.friction * impulse[:, 0] + problem.friction_bias
    exact = reference_answer(problem)
    nets = {} if exact is None or problem.contacts > MOST_FORCES else _net_impulses(problem, impulse, exact)
    forces = np.column_stack([impulse[:, 0], np.linalg.norm(impulse[:, 1:], axis=1), limit])
    return Judgement(
        file=path.name,
        problem=problem.hash,
        contacts=problem.contacts,
        residual=size,
        floor=floor,
        law=law,
        **largest,
        creep=None if exact is None else _creep(problem, impulse, exact),
        free_velocity=float(problem.velocity_scale),
        net_impulses=nets,
        penetration=penetration(step),
        energy_defect=ledger_defect(problem, impulse),
        notes=dict(step.notes),
        forces=forces[:MOST_FORCES].tolist(),
        unloaded=bool(unloaded),
        contradiction="" if exact is not None else str(contradiction(problem) or ""),
    )


def _creep(problem: FrictionProblem, impulse: Array, exact: Array) -> float | None:
    """Return the largest slip, in m/s, at the contacts that stick in the exact answer, or None if there are none."""
    slip = np.linalg.norm(problem.contact_velocity(exact)[:, 1:], axis=1)
    sticking = (slip <= STICKING_SLIP * problem.units) & (exact[:, 0] > STICKING_SLIP * problem.units / problem.scale)
    own_slip = np.linalg.norm(problem.contact_velocity(impulse)[:, 1:], axis=1)
    return float(own_slip[sticking].max()) if sticking.any() else None


def _net_impulses(problem: FrictionProblem, impulse: Array, exact: Array) -> dict[str, NetImpulse]:
    """Return the net impulse of the contacts between each two bodies, by their velocities' indices; dry friction of joints has
    none.

    The motion determines the impulses z of closed contacts and of joints up to the null space of A', where A has rows J for a
    sticking contact, (1, -mu u_t/|u_t|)'J for a sliding one, and F for joints. The impulse that stops the creep is the
    least z with B M^-1 A' z = -w, where B has rows J for sticking contacts, J_n for sliding ones, and F, and w is the engine's
    slip at sticking contacts and 0 in the other rows.
    """
    if not problem.mechanical or not problem.contacts:
        return {}
    nc, d = problem.contacts, problem.dimension
    J = problem.jacobian.toarray().reshape(nc, d, -1)
    u, creep = problem.contact_velocity(exact), problem.contact_velocity(impulse) * ([0.0] + [1.0] * (d - 1))
    slip = np.linalg.norm(u[:, 1:], axis=1)
    F = problem.joints.toarray()
    parts = [(F, F, np.zeros(len(F)), np.full(len(F), -1))]
    for i in np.flatnonzero(u[:, 0] <= STICKING_SLIP * problem.units):
        slides = slip[i] > STICKING_SLIP * problem.units[i]
        along = np.concatenate([[1.0], -problem.friction[i] * u[i, 1:] / slip[i]])[None] @ J[i] if slides else J[i]
        parts.append((along, J[i][: len(along)], creep[i][: len(along)], np.full(len(along), i)))
    A, B, w, owners = (np.concatenate(each) for each in zip(*parts, strict=True))
    stop = -np.linalg.lstsq(B @ (problem.inverse_mass @ A.T), w, rcond=RANK_TOL)[0]
    free, between = null_space(A.T, rcond=RANK_TOL), [tuple(np.flatnonzero(rows.any(axis=0)).tolist()) for rows in J]
    change, v = np.einsum("cdv,cd->v", J, exact), problem.free_velocity
    largest = max(change @ (problem.inverse_mass @ change), v @ (problem.mass @ v))
    rounding = RANK_TOL * np.sqrt(largest)  # differences of smaller net impulses mean nothing
    nets_by_velocities = {}
    pressing = np.flatnonzero(J[:, 0].any(axis=1))  # dry friction of a joint has no normal
    for velocities in dict.fromkeys(between[i] for i in pressing):
        between_them = [i for i in pressing if between[i] == velocities]
        bears = np.isin(owners, between_them)
        nets = [np.einsum("cdv,cd->v", J[between_them], r[between_them]) for r in (impulse, exact)]
        vectors = (nets[0] - nets[1], nets[0] + stop[bears] @ A[bears] - nets[1], *nets)
        size = [float(np.sqrt(max(net @ (problem.inverse_mass @ net), 0.0))) for net in vectors]
        alone = not (np.abs(free[bears]) > RANK_TOL).any()
        net_known = alone or not (np.abs(A[bears].T @ free[bears]) > RANK_TOL * np.abs(A).max(initial=0.0)).any()
        whole = max(*size[2:], rounding) or 1.0
        shown = ([float(net[v]) for v in velocities] for net in nets)
        found = NetImpulse(len(between_them), net_known, alone, size[0] / whole, size[1] / whole, *shown)
        nets_by_velocities[_ranges(velocities)] = found
    return nets_by_velocities


def _ranges(numbers: tuple[int, ...]) -> str:
    """Return sorted numbers as text: (0, 1, 2, 6) as "0 to 2, 6"."""
    runs = [[number for _, number in run] for _, run in groupby(enumerate(numbers), key=lambda pair: pair[1] - pair[0])]
    return ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)


def judge_step(path: str) -> dict[str, Any]:
    """In a worker, return the fields of the judgement on the step in a file."""
    return judge_file(worker.folder(), Path(path)).as_data()


def prepared(
    folder: Path,
    against: tuple[str, ...],
    plugins: tuple[Plugin, ...],
    tol: float,
    time_limit: float,
    jobs: int,
    out: Path | None,
    progress: Progress,
) -> tuple[Plan, Path]:
    """Judge the steps in folder/*.npz or in one file; return the plan with OUR_SOLVER and `against` on them, and its folder.

    out: by default a folder in runs/ named by a hash of the judgements and the settings. Errors: InputError naming
    the folder or file that cannot be used, ResultsError if out holds another run.
    """
    require(0 < tol < 1, "tol", f"must lie between 0 and 1, got {tol}")
    for name in set(against).difference(*(plugin.solvers for plugin in plugins)):
        require(not (missing := find(name)[0].missing), "against", str(missing))
    require(folder.exists(), "folder", f"there is no folder or file {folder}")
    paths = [folder] if folder.is_file() else sorted(folder.glob("[!.]*.npz"), key=natural)
    require(bool(paths), "folder", f"{folder} holds no steps of an engine, *.npz; docs/engines.md says how to write them")
    with scratch_pool(jobs=jobs) as pool:
        judgements = _judgements(paths, pool, progress)
        require(any(one.contacts for one in judgements), "folder", f"no step in {folder} has a contact")
        solvers = tuple(dict.fromkeys((OUR_SOLVER, *against)))
        judged_by = json.dumps([folder.resolve().name, [one.as_data() for one in judgements], solvers, tol, time_limit])
        out = out or Path("runs") / f"judge-{sha256(judged_by.encode()).hexdigest()[:8]}"
        plan = Plan("judge", _sources(folder, judgements, out), solvers, (tol,), time_limit=time_limit, plugins=plugins)
        open_folder(plan, out)
        for path in (pool.folder / FOLDER).iterdir():
            with replaced(subfolder(out, FOLDER) / path.name) as file:  # shutil.move writes through a link
                copyfile(path, file)
    write_judgements(out, judgements)
    return plan, out


def _judgements(paths: list[Path], pool: Pool, progress: Progress) -> list[Judgement]:
    """Return the judgements in the order of the paths. Errors: InputError naming the first file that cannot be judged."""
    tasks = [Task(judge_step, (str(path.absolute()),), COLLECT_SECONDS) for path in paths]
    judgements = {
        outcome.task.arguments: parsed(outcome.result(f"{outcome.task.arguments[0]}: cannot be judged"), Judgement, FILE)
        for outcome in progress.follow("steps", pool, tasks)
    }
    return [judgements[task.arguments] for task in tasks]


def _sources(folder: Path, judgements: list[Judgement], out: Path) -> tuple[Source, ...]:
    """Return the problems that the steps with contacts are judged by, each problem once."""
    steps = {one.problem: one.file for one in reversed(judgements) if one.contacts}
    stored = out.absolute() / FOLDER
    name = folder.resolve().name
    return tuple(Source(name, {"file": file}, file=str(stored / f"{problem}.npz")) for problem, file in reversed(steps.items()))
