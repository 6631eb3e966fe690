"""The problems of the cells: recorded along a simulation with verified reference answers, labelled, and stored by their hash.

A recorded problem also has starts, the same for every solver that accepts one: `warm`, the impulses of the previous problem of
the same phase, and `shuffled`, those of a problem drawn from the whole motion. Both are transferred contact by contact. For a
file, `warm` is the initial guess of an FCLIB file, unless it is zero, or else the reference answer of the preceding file if
both have the same numbers of contacts and velocities.

The reference answer, refined to rounding level, is stored with its problem, and velocities are compared with it. The list of a
source's problems is stored too (harness.cells.stored).
"""

import json
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictionbench.harness.cells.reference import LARGEST_RESIDUAL, NoReference, Reference, reference_answer, unless_unsolved
from frictionbench.harness.cells.rows import blank_facts
from frictionbench.harness.cells.stored import Record, answer_file, digest_of, read_records, starts_file
from frictionbench.harness.plans import robots
from frictionbench.harness.plans.plan import Source, origin
from frictionbench.problems import LCP, FrictionProblem, InputError
from frictionbench.problems.analysis.census import census_labels
from frictionbench.problems.analysis.contradiction import contradiction
from frictionbench.problems.analysis.frictionless import idle
from frictionbench.problems.analysis.labels import POINTED, labels, lcp_size
from frictionbench.problems.analysis.mode import distance_to_next_mode
from frictionbench.problems.analysis.outcomes import refined
from frictionbench.problems.analysis.stability import sensitivity
from frictionbench.problems.analysis.thresholds import existence
from frictionbench.problems.catalogue import instances, make_instance, scene
from frictionbench.problems.check import Array, require
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.recorded import read_recording
from frictionbench.problems.recorded.native import save
from frictionbench.problems.residual import residual
from frictionbench.problems.scene import Scene
from frictionbench.problems.simulate import first_problem_of, simulate
from frictionbench.results.conventions import COLD, DEFAULT_SCHEME, ROBOT_STEP, SHUFFLED, WARM, first_phase
from frictionbench.results.files import ResultsError, replaced, subfolder, write_text

MAX_PERTURBED = 30  # contacts: the sensitivity takes several solves per contact, too long for larger problems
MAX_COUNTED = 6  # contacts: the number of modes to enumerate grows as 4^contacts


class Collected(NamedTuple):
    """A problem, its step, phase, contacts and answer. reference: solvers of the answers up to it; idle: None if unknown."""

    step: int
    phase: str
    problem: FrictionProblem
    contacts: Contacts | None = None
    impulse: Array | None = None
    reference: str = ""
    idle: bool | None = None


def collect(folder: Path, source: Source, described: bool = True) -> list[Record]:
    """Store the source's problems in folder/problems, unless they are stored already, and return their records.

    described: whether to compute reference answers and labels, which takes longer than making the problems.
    Errors: InputError with the reason if the source yields no problem.
    """
    store = subfolder(folder, "problems")
    listed = store / f"{source.key}.json"
    with suppress(ResultsError, FileNotFoundError):  # a list that was edited is collected again
        known = read_records(listed)
        facts_of_source = source.scene, json.dumps(source.parameters, sort_keys=True)
        if all((record["scene"], record["parameters"]) == facts_of_source for record in known):
            return [record | {"repeats": source.repeats} for record in known]
    records: dict[str, Record] = {}
    for collected, starts in _recorded(source) if source.file else _chosen(source):
        problem = collected if isinstance(collected, LCP) else collected.problem
        name = problem.hash
        if name not in records:
            with replaced(store / f"{name}.npz") as file:
                save(problem, file)
            if isinstance(collected, LCP):  # it has no contacts
                columns = {"size": collected.size, "trivial": bool((collected.q >= 0).all()), "idle": False}
                record = blank_facts(source, name, 0, "lcp") | columns
            elif described:
                record = _answered_facts(folder, source, collected)
            else:
                contacts, dimension = collected.problem.contacts, collected.problem.dimension
                columns = {"contacts": contacts, "dimension": dimension, "size": lcp_size(collected.problem)}
                record = blank_facts(source, name, collected.step, collected.phase) | columns
            digests = {COLD: ""} | {start: digest_of(impulses) for start, impulses in starts.items()}
            records[name] = record | {"starts": digests, "repeats": source.repeats}
            if starts:
                with replaced(starts_file(folder, name, origin(records[name]))) as file:
                    np.savez(file, **starts)  # type: ignore[arg-type]
    write_text(listed, json.dumps(list(records.values())))
    return list(records.values())


def _answered_facts(folder: Path, source: Source, collected: Collected) -> Record:
    """Store a problem's refined reference answer, if it has one, and return its facts."""
    answer = reference_answer(collected.problem) if collected.impulse is None else collected.impulse
    finest = None if answer is None else refined(collected.problem, answer)
    if finest is not None:
        with replaced(answer_file(folder, collected.problem.hash)) as file:
            np.savez(file, impulse=finest)
    return facts(source, collected._replace(impulse=answer))


def _recorded(source: Source) -> list[tuple[Collected | LCP, dict[str, Array]]]:
    """Return the problem in the source's file. It starts from the file's initial guess, or else the previous step's answer."""
    problem, guesses = read_recording(Path(source.file))
    if isinstance(problem, LCP):
        return [(problem, {})]
    starts, reference = {WARM: guesses[0]} if guesses and guesses[0].any() else {}, ""
    if source.before and not starts:
        starts, reference = _from_step_before(Path(source.before), problem)
    return [(Collected(source.step, first_phase(DEFAULT_SCHEME), problem, reference=reference), starts)]


def _from_step_before(path: Path, problem: FrictionProblem) -> tuple[dict[str, Array], str]:
    """Return the reference answer to the problem in the preceding file as a warm start, and its solver.

    Both are empty if that problem has no answer, or other numbers of contacts or velocities: files do not identify contacts.
    """
    try:
        before, reference = read_recording(path)[0], Reference()
        if isinstance(before, LCP) or _numbers(before) != _numbers(problem):
            return {}, ""
        return {WARM: reference(before)}, str(reference)
    except (InputError, NoReference):
        return {}, ""


def _numbers(problem: FrictionProblem) -> tuple[int, int, int]:
    return problem.dimension, problem.contacts, len(problem.free_velocity)


def _chosen(source: Source) -> list[tuple[Collected, dict[str, Array]]]:
    """Return the source's problems, each with its starts by name. Of a motion, problems that are not idle are preferred."""
    if source.scene in instances():
        known = robots.kept(f"{source.parameters['case']} start") if source.scene == ROBOT_STEP else None
        starts = {} if known is None else {WARM: known}
        return [(Collected(0, first_phase(DEFAULT_SCHEME), make_instance(source.scene, **source.parameters)), starts)]
    stage = scene(source.scene, **source.parameters)
    if source.pick == 0:
        return [(Collected(0, first_phase(source.scheme), first_problem_of(stage, source.scheme)), {})]
    collected, ended = _motion(stage, source.steps)
    require(bool(collected), "scene", f"{source.scene} yields no problem{': ' if ended else ''}{ended}")
    collected = [each._replace(idle=_idle(each.problem)) for each in collected]
    working = [i for i, each in enumerate(collected) if not each.idle] or range(len(collected))
    chosen = [working[i] for i in np.unique(np.linspace(0, len(working) - 1, min(source.pick, len(working))).astype(int))]
    last = collected[-1]
    reference = f"{last.reference}; the motion ended after step {last.step}: {ended}" if ended else last.reference
    return [(collected[i]._replace(reference=reference), _starts(collected, i)) for i in chosen]


def _motion(stage: Scene, steps: int | None) -> tuple[list[Collected], str]:
    """Return the problems of a motion that zero impulses do not solve, and why the motion ended early, or empty."""
    reference, collected = Reference(), []
    try:
        for index, step in enumerate(simulate(stage, reference, steps=steps)):
            collected += [
                Collected(index, solved.phase, solved.problem, step.contacts, solved.impulse, str(reference))
                for solved in step.solved
                if residual(solved.problem, 0 * solved.impulse) > 0
            ]
    except NoReference as finding:
        return collected, str(finding)
    return collected, ""


def _starts(collected: list[Collected], i: int) -> dict[str, Array]:
    before = [j for j in range(i) if collected[j].phase == collected[i].phase]
    others = [j for j in range(len(collected)) if j != i and collected[j].phase == collected[i].phase]
    starts = {}
    if before:
        starts[WARM] = _transferred(collected[before[-1]], collected[i])
    if others:
        starts[SHUFFLED] = _transferred(collected[int(np.random.default_rng(i).choice(others))], collected[i])
    return starts


def _transferred(known: Collected, wanted: Collected) -> Array:
    """Return the known impulses at the wanted contacts, zero at new contacts."""
    assert known.contacts is not None
    assert wanted.contacts is not None
    assert known.impulse is not None
    impulses = {
        tuple(feature): impulse for feature, impulse in zip(known.contacts.feature.tolist(), known.impulse, strict=True)
    }
    zero = np.zeros(wanted.problem.dimension)
    transferred = [impulses.get(tuple(feature), zero) for feature in wanted.contacts.feature.tolist()]
    return np.array(transferred).reshape(wanted.problem.contacts, wanted.problem.dimension)


def facts(source: Source, collected: Collected) -> Record:
    """Return the columns of a row that describe a problem (results.schema.PROBLEM_FACTS). Some need its reference answer."""
    problem, answer = collected.problem, collected.impulse
    nc, planar, labelled = problem.contacts, problem.dimension == 2, labels(problem)
    trivial = bool(labelled["trivial"])
    proof = contradiction(problem) if answer is None else None
    infeasible = proof is not None and bool(proof.least_residual > LARGEST_RESIDUAL)  # no answer would be accepted
    row = blank_facts(source, problem.hash, collected.step, collected.phase, collected.reference) | labelled
    row |= {"trivial": trivial, "proved_infeasible": infeasible}
    row["idle"] = not trivial and (_idle(problem) if collected.idle is None else collected.idle)
    if planar and nc <= MAX_COUNTED:
        row |= census_labels(problem)
    known = "none" if infeasible else existence(problem, labelled["pointedness"] <= POINTED)  # by theory, otherwise by counting
    row["existence"] = known or {None: "", "none": "none"}.get(row["solutions"], "counted")
    if nc <= MAX_PERTURBED:  # infinite if the problem, or a perturbed one, has no verified answer
        row["sensitivity"] = unless_unsolved(np.inf, lambda solve: sensitivity(problem, solve))
    if answer is not None and planar and 0 < nc <= MAX_PERTURBED:
        row["mode_distance"] = distance_to_next_mode(problem, answer)
    return row


def _idle(problem: FrictionProblem) -> bool:
    """Return whether friction is not needed; False if the frictionless problem has no reference answer."""
    return unless_unsolved(False, lambda solve: idle(problem, solve))
