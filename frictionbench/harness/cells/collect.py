"""The problems of the cells: recorded along a simulation with verified reference answers, labelled, and stored by their hash.

A recorded problem also has starts, the same for every solver that takes one: `warm`, the impulses of the previous problem of
the same phase, and `shuffled`, those of a problem drawn from the whole motion; both transferred contact by contact. `warm` is
also a guess in a file of FCLIB's, unless it is zero, and the answer of the file before where it has as many contacts.

The reference answer, refined to what rounding allows, stands beside its problem: velocities are compared with it.

The list of a source's problems is stored too. A folder may come from someone else, so that each record is checked.
"""

import json
from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, Json

from frictionbench.harness.cells.reference import LARGEST, NoReference, Reference, reference_answer, unless_unsolved
from frictionbench.harness.cells.rows import blank_facts
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
from frictionbench.problems.recorded.archive import read_arrays
from frictionbench.problems.recorded.own import load, save
from frictionbench.problems.residual import residual
from frictionbench.problems.scene import Scene
from frictionbench.problems.simulate import first_problem_of, simulate
from frictionbench.results.conventions import COLD, DEFAULT_SCHEME, SHUFFLED, WARM, first_phase
from frictionbench.results.files import ResultsError, parsed, read_json, replaced, subfolder, write_text
from frictionbench.results.schema import PROBLEM_FACTS

Record = dict[str, Any]  # the facts of a stored problem: PROBLEM_FACTS, its starts and repeats


@dataclass
class _Stored:
    """What a stored record is checked for: it names files, and its facts are columns."""

    problem: Annotated[str, Field(pattern="^[0-9a-f]{8,64}$")]
    scene: str
    parameters: Json[dict[str, Any]]
    step: Annotated[int, Field(strict=True, ge=0, lt=10**9)]
    phase: str
    contacts: Annotated[int | None, Field(strict=True)]
    starts: dict[Literal["cold", "warm", "shuffled"], str]


def read_records(path: Path) -> list[Record]:
    """The records in a file that collect wrote. Errors: ResultsError naming the file, where it is none or is damaged."""
    records = read_json(path)
    parsed(records, Annotated[list[_Stored], Field(min_length=1)], path)  # type: ignore[arg-type]
    if not all(record.keys() >= {*PROBLEM_FACTS} and list(record["starts"])[:1] == [COLD] for record in records):
        raise ResultsError(f"{path}: not a list of problems")
    return records


MAX_PERTURBED = 30  # contacts: the sensitivity takes several solves for each, too long for larger problems
MAX_COUNTED = 6  # contacts: the number of modes to enumerate grows like 4^contacts


class Collected(NamedTuple):
    """A problem with its step and phase, its contacts, its answer, the solvers of the reference answers before it, and whether
    it is idle, where that is known."""

    step: int
    phase: str
    problem: FrictionProblem
    contacts: Contacts | None = None
    impulse: Array | None = None
    reference: str = ""
    idle: bool | None = None


def collect(folder: Path, source: Source, described: bool = True) -> list[Record]:
    """The records of the source's problems, which are stored under folder/problems; read where they were stored before.

    described: whether they are solved for their reference answers and labelled, which takes longer than to make them.
    Errors: InputError with the reason where the source yields no problem.
    """
    store = subfolder(folder, "problems")
    listed = store / f"{source.key}.json"
    with suppress(ResultsError, FileNotFoundError):  # one that was edited is collected again
        known = read_records(listed)
        facts_of_source = source.scene, json.dumps(source.parameters, sort_keys=True)
        if all((record["scene"], record["parameters"]) == facts_of_source for record in known):
            return [record | {"repeats": source.repeats} for record in known]
    records: dict[str, Record] = {}
    for found, starts in _recorded(source) if source.file else _chosen(source):
        problem = found if isinstance(found, LCP) else found.problem
        name = problem.hash
        if name not in records:
            with replaced(store / f"{name}.npz") as file:
                save(problem, file)
            if isinstance(found, LCP):
                record = lcp_facts(source, found)
            else:
                record = _answered_facts(folder, source, found) if described else _size_facts(source, found)
            digests = {COLD: ""} | {start: _digest(impulses) for start, impulses in starts.items()}
            records[name] = record | {"starts": digests, "repeats": source.repeats}
            if starts:
                with replaced(_starts_file(folder, name, origin(records[name]))) as file:
                    np.savez(file, **starts)  # type: ignore[arg-type]
    write_text(listed, json.dumps(list(records.values())))
    return list(records.values())


def _answered_facts(folder: Path, source: Source, found: Collected) -> Record:
    """The facts of a problem, whose refined reference answer is stored."""
    answer = reference_answer(found.problem) if found.impulse is None else found.impulse
    finest = None if answer is None else refined(found.problem, answer)
    if finest is not None:
        with replaced(_answer_file(folder, found.problem.hash)) as file:
            np.savez(file, impulse=finest)
    return facts(source, found._replace(impulse=answer))


def stored(folder: Path, problem: str) -> FrictionProblem | LCP:
    """A stored problem by its hash. Errors: InputError where the file is missing, damaged, or holds another problem."""
    path = folder / "problems" / f"{problem}.npz"
    found = load(path)
    require(found.hash == problem, str(path), f"holds another problem, {found.hash}, than the one its name is the hash of")
    return found


def stored_friction(folder: Path, problem: str) -> FrictionProblem:
    """A stored friction problem by its hash. Errors: InputError as stored, and where it is a bare LCP."""
    found = stored(folder, problem)
    if isinstance(found, LCP):
        raise InputError(f"problem: {problem} is a bare LCP, without contacts")
    return found


def stored_answer(folder: Path, problem: str) -> Array | None:
    """The refined reference answer (nc, d) of a stored problem, None where there is none that can be read."""
    with suppress(InputError, KeyError):
        return read_arrays(_answer_file(folder, problem))["impulse"]
    return None


def _answer_file(folder: Path, problem: str) -> Path:
    return folder / "problems" / f"{problem}.answer.npz"


def stored_start(folder: Path, problem: str, source_origin: str, start: str, digest: str = "") -> Array | None:
    """The impulses (nc, d) to start from, of the motion that the problem comes from; None for a cold start.

    digest: that in the problem's record; not compared if it is empty. Errors: InputError naming the file.
    """
    if start == COLD:
        return None
    path = _starts_file(folder, problem, source_origin)
    try:
        impulses = read_arrays(path)[start]
    except (InputError, KeyError):
        raise InputError(f"{path}: the start {start} cannot be read: the file is missing or damaged") from None
    same = not digest or _digest(impulses) == digest
    require(same, str(path), f"holds another start {start} than the one that was collected")
    return impulses


def _digest(impulses: Array) -> str:
    return sha256(repr(impulses.shape).encode() + np.ascontiguousarray(impulses, float).tobytes()).hexdigest()


def _starts_file(folder: Path, problem: str, source_origin: str) -> Path:
    return folder / "problems" / f"{problem}.{sha256(source_origin.encode()).hexdigest()[:8]}.starts.npz"


def files_of(folder: Path, problem: str, source_origin: str) -> list[Path]:
    """The files of a stored problem that exist; the folder, which may hold very many, is not listed."""
    own, answer = folder / "problems" / f"{problem}.npz", _answer_file(folder, problem)
    return [path for path in (own, answer, _starts_file(folder, problem, source_origin)) if path.exists()]


def _recorded(source: Source) -> list[tuple[Collected | LCP, dict[str, Array]]]:
    """The problem in the source's file; its warm start is the file's initial guess, or else the answer of the step before."""
    problem, guesses = read_recording(Path(source.file))
    if isinstance(problem, LCP):
        return [(problem, {})]
    starts, reference = {WARM: guesses[0]} if guesses and guesses[0].any() else {}, ""
    if source.before and not starts:
        starts, reference = _from_step_before(Path(source.before), problem)
    return [(Collected(source.step, first_phase(DEFAULT_SCHEME), problem, reference=reference), starts)]


def _from_step_before(path: Path, problem: FrictionProblem) -> tuple[dict[str, Array], str]:
    """The reference answer of the problem in this file as a warm start, and its solver.

    Nothing where that has no answer, or other numbers of contacts and velocities: files do not say which contacts are the same.
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
    """The source's problems, each with its starts by name; of a motion those in which friction is at work, if there are any."""
    if source.scene in instances():
        known = robots.kept(f"{source.parameters['case']} start") if source.scene == robots.SCENE else None
        starts = {} if known is None else {WARM: known}
        return [(Collected(0, first_phase(DEFAULT_SCHEME), make_instance(source.scene, **source.parameters)), starts)]
    stage = scene(source.scene, **source.parameters)
    if source.pick == 0:
        return [(Collected(0, first_phase(source.scheme), first_problem_of(stage, source.scheme)), {})]
    found, ended = _motion(stage, source.steps)
    require(bool(found), "scene", f"{source.scene} yields no problem{': ' if ended else ''}{ended}")
    found = [each._replace(idle=_idle(each.problem)) for each in found]
    working = [i for i, each in enumerate(found) if not each.idle] or range(len(found))
    chosen = [working[i] for i in np.unique(np.linspace(0, len(working) - 1, min(source.pick, len(working))).astype(int))]
    last = found[-1]
    reference = f"{last.reference}; the motion ended after step {last.step}: {ended}" if ended else last.reference
    return [(found[i]._replace(reference=reference), _starts(found, i)) for i in chosen]


def _motion(stage: Scene, steps: int | None) -> tuple[list[Collected], str]:
    """The problems of a motion that zero does not solve, and why the motion ended early, if it did."""
    reference, found = Reference(), []
    try:
        for index, step in enumerate(simulate(stage, reference, steps=steps)):
            found += [
                Collected(index, solved.phase, solved.problem, step.contacts, solved.impulse, str(reference))
                for solved in step.solved
                if residual(solved.problem, 0 * solved.impulse) > 0  # zero does not solve it
            ]
    except NoReference as finding:
        return found, str(finding)
    return found, ""


def _starts(found: list[Collected], i: int) -> dict[str, Array]:
    before = [j for j in range(i) if found[j].phase == found[i].phase]
    others = [j for j in range(len(found)) if j != i and found[j].phase == found[i].phase]
    starts = {}
    if before:
        starts[WARM] = _transferred(found[before[-1]], found[i])
    if others:
        starts[SHUFFLED] = _transferred(found[int(np.random.default_rng(i).choice(others))], found[i])
    return starts


def _transferred(known: Collected, wanted: Collected) -> Array:
    """The known impulses at the wanted contacts; zero at contacts that were not there."""
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
    """The columns of a row that describe a problem, with its reference answer if there is one:
    results.schema.PROBLEM_FACTS."""
    problem, answer = collected.problem, collected.impulse
    nc, planar, found = problem.contacts, problem.dimension == 2, labels(problem)
    proof = contradiction(problem) if answer is None else None
    infeasible = proof is not None and bool(proof.least_residual > LARGEST)  # no answer would be accepted
    row = blank_facts(source, problem.hash, collected.step, collected.phase, collected.reference) | vars(found)
    row |= {
        "contacts": nc,
        "dimension": problem.dimension,
        "velocities": len(problem.free_velocity),
        "redundancy": None if found.rank is None else nc * problem.dimension - found.rank,
        "trivial": bool(found.trivial),
        "idle": not found.trivial and (_idle(problem) if collected.idle is None else collected.idle),
        "proved_infeasible": infeasible,
    }
    if planar and nc <= MAX_COUNTED:
        counted = census_labels(problem)
        row |= {"solutions": counted["solutions"], "outcomes": counted["velocity_count"]}
    known = "none" if infeasible else existence(problem, found.pointedness <= POINTED)  # by theory, else by counting
    row["existence"] = known or {None: "", "none": "none"}.get(row["solutions"], "counted")
    if nc <= MAX_PERTURBED:  # infinite where the problem, or one near it, has no answer that holds
        row["sensitivity"] = unless_unsolved(np.inf, lambda solve: sensitivity(problem, solve))
    if answer is not None and planar and 0 < nc <= MAX_PERTURBED:
        row["mode_distance"] = distance_to_next_mode(problem, answer)
    return row


def _size_facts(source: Source, collected: Collected) -> Record:
    """Those of them that the problem states: its contacts, its dimension and the size of its LCP."""
    problem = collected.problem
    sizes = {"contacts": problem.contacts, "dimension": problem.dimension, "size": lcp_size(problem)}
    return blank_facts(source, problem.hash, collected.step, collected.phase) | sizes


def lcp_facts(source: Source, lcp: LCP) -> Record:
    """The columns of a row that describe a bare LCP, which has no contacts."""
    return blank_facts(source, lcp.hash, 0, "lcp") | {"size": lcp.size, "trivial": bool((lcp.q >= 0).all()), "idle": False}


def _idle(problem: FrictionProblem) -> bool:
    """Whether friction is not needed; not known to be so where the problem without friction has no reference answer."""
    return unless_unsolved(False, lambda solve: idle(problem, solve))
