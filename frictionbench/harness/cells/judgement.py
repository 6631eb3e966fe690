"""The judgement on one step of an engine: its own impulses through the verifier's residual, and by law."""

from pathlib import Path

import numpy as np

from frictionbench.harness.cells.reference import NoReference, Reference
from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.recorded import own
from frictionbench.problems.residual import contact_residuals, residual_floor
from frictionbench.problems.simulate import ledger_defect
from frictionbench.problems.violations import judged, penetration, violations
from frictionbench.results.files import replaced, subfolder
from frictionbench.results.judgement import LAWS, Judgement

FOLDER = "judged"
STICKS = 1e-6  # of a contact's unit of velocity: slip in the exact answer below counts as none
MOST_FORCES = 200  # contacts whose forces are kept for a figure


def judge_file(folder: Path, path: Path) -> Judgement:
    """Judge the step in a file, and store the problem by which it is judged as folder/judged/HASH.npz.

    Errors: InputError naming the file, or the field in it that cannot be used.
    """
    step = own.load_step(path)
    problem, impulse = judged(step), step.impulse
    with replaced(subfolder(folder, FOLDER) / f"{problem.hash}.npz") as file:
        own.save(problem, file)
    by_contact, laws = contact_residuals(problem, impulse), violations(problem, impulse)
    largest = dict(zip(LAWS, (float(one.max(initial=0.0)) for one in laws), strict=True))
    law = LAWS[int(np.argmax([one[by_contact.argmax()] for one in laws]))] if problem.contacts else ""
    limit = problem.friction * impulse[:, 0] + problem.friction_bias
    forces = np.column_stack([impulse[:, 0], np.linalg.norm(impulse[:, 1:], axis=1), limit])
    return Judgement(
        file=path.name,
        problem=problem.hash,
        contacts=problem.contacts,
        residual=float(by_contact.max(initial=0.0)),
        floor=residual_floor(problem, impulse),
        law=law,
        **largest,
        creep=_creep(problem, impulse),
        penetration=penetration(step),
        energy_defect=ledger_defect(problem, impulse),
        notes=dict(step.notes),
        forces=forces[:MOST_FORCES].tolist(),
    )


def _creep(problem: FrictionProblem, impulse: Array) -> float | None:
    """The largest slip, m/s, at the contacts that stick in the exact answer; None without such an answer or such contacts."""
    if not problem.contacts:
        return None
    try:
        exact = Reference()(problem)
    except NoReference:
        return None
    slip = np.linalg.norm(problem.contact_velocity(exact)[:, 1:], axis=1)
    sticking = (slip <= STICKS * problem.units) & (exact[:, 0] > STICKS * problem.units / problem.scale)
    own_slip = np.linalg.norm(problem.contact_velocity(impulse)[:, 1:], axis=1)
    return float(own_slip[sticking].max()) if sticking.any() else None
