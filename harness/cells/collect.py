"""Problems for the cells: recorded along a simulation that verified reference answers step, labelled and stored by their hash.

A recorded problem has starts too, the same for every solver that takes one: `warm`, the impulses of the problem of the same
phase before it, and `shuffled`, those of one drawn from the whole motion; both carried over contact by contact. The first guess
that a file of FCLIB's holds, what its recorder began with, is `warm` too, where it is more than zeros.
"""

import json
import zipfile
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from frictionbench.harness.cells.reference import NoReference, Reference
from frictionbench.harness.cells.rows import PROBLEM_FACTS
from frictionbench.harness.plans.plan import Source, origin
from frictionbench.problems import LCP, FrictionProblem, InputError, scene
from frictionbench.problems.analysis.census import census_labels
from frictionbench.problems.analysis.labels import labels
from frictionbench.problems.analysis.mode import distance_to_next_mode
from frictionbench.problems.analysis.stability import sensitivity
from frictionbench.problems.analysis.thresholds import POINTED, existence
from frictionbench.problems.check import Array
from frictionbench.problems.instances import instances, make_instance
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.recorded import read_recording
from frictionbench.problems.recorded.own import load, save
from frictionbench.problems.residual import residual
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes import SCHEMES
from frictionbench.problems.simulate import first_problem, simulate
from frictionbench.results.conventions import COLD, DEFAULT_SCHEME, SHUFFLED, WARM, first_phase
from frictionbench.results.files import replaced, subfolder, write_text

MOST_PERTURBED = 30  # contacts; larger problems would take too long for what their sensitivity says
MOST_COUNTED = 6  # contacts; the modes to enumerate grow like 4^contacts
Entry = dict[str, Any]


class Met(NamedTuple):
    """A problem as it was met, the contacts it is about, its answer, and who answered those before it."""

    step: int
    phase: str
    problem: FrictionProblem
    contacts: Contacts | None = None
    impulse: Array | None = None
    reference: str = ""


def collect(folder: Path, source: Source) -> list[Entry]:
    """The source's problems, stored under folder/problems, as plain rows of facts; stored once, then read.

    Errors: InputError with the reason where it yields none.
    """
    store = subfolder(folder, "problems")
    listed = store / f"{source.key}.json"
    if listed.exists():
        return json.loads(listed.read_text(encoding="utf-8"))
    entries: dict[str, Entry] = {}
    for found, starts in _recorded(source) if source.file else _chosen(source):
        problem = found if isinstance(found, LCP) else found.problem
        name = problem.hash
        if name not in entries:
            with replaced(store / f"{name}.npz") as file:
                save(problem, file)
            told = lcp_facts(source, found) if isinstance(found, LCP) else facts(source, found)
            entries[name] = told | {"starts": [COLD, *starts], **_own_terms(source)}
            if starts:
                with replaced(_starts_of(folder, name, origin(entries[name]))) as file:
                    np.savez(file, **starts)  # type: ignore[arg-type]
    write_text(listed, json.dumps(list(entries.values())))
    return list(entries.values())


def _own_terms(source: Source) -> Entry:
    """What the source asks for in place of the plan's tolerances and limit."""
    terms: Entry = {"repeats": source.repeats}
    if source.tolerances:
        terms["tolerances"] = list(source.tolerances)
    if source.time_limit is not None:
        terms["time_limit"] = source.time_limit
    return terms


def stored(folder: Path, problem: str) -> FrictionProblem | LCP:
    """A stored problem by its hash. Errors: InputError where the file is missing or damaged."""
    return load(folder / "problems" / f"{problem}.npz")


def stored_friction(folder: Path, problem: str) -> FrictionProblem:
    """A stored friction problem by its hash. Errors: InputError as stored, and where it is a bare LCP."""
    found = stored(folder, problem)
    if isinstance(found, LCP):
        raise InputError(f"problem: {problem} is a bare LCP, without contacts")
    return found


def stored_start(folder: Path, problem: str, home: str, start: str) -> Array | None:
    """The impulses (nc, d) to start from, those of the motion that the problem is from; None for a cold start."""
    if start == COLD:
        return None
    path = _starts_of(folder, problem, home)
    try:
        with np.load(path, allow_pickle=False) as starts:
            return starts[start]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: no usable start {start} ({error})") from None


def _starts_of(folder: Path, problem: str, home: str) -> Path:
    return folder / "problems" / f"{problem}.{sha256(home.encode()).hexdigest()[:8]}.starts.npz"


def _recorded(source: Source) -> list[tuple[Met | LCP, dict[str, Array]]]:
    """The problem in the source's file, and the guess that it offers to start from."""
    problem, guesses = read_recording(Path(source.file))
    if isinstance(problem, LCP):
        return [(problem, {})]
    return [(Met(0, first_phase(DEFAULT_SCHEME), problem), {WARM: guesses[0]} if guesses and guesses[0].any() else {})]


def _chosen(source: Source) -> list[tuple[Met, dict[str, Array]]]:
    """The source's problems, each with its starts by name."""
    if source.scene in instances():
        return [(Met(0, first_phase(DEFAULT_SCHEME), make_instance(source.scene, **source.parameters)), {})]
    stage = scene(source.scene, **source.parameters)
    if source.pick == 0:
        return [(Met(0, first_phase(source.scheme), first_problem_of(stage, source.scheme)), {})]
    met, ended = _motion(stage, source.steps)
    if not met:
        raise InputError(f"scene: {source.scene} yields no problem{': ' if ended else ''}{ended}")
    chosen = np.unique(np.linspace(0, len(met) - 1, min(source.pick, len(met))).astype(int))
    told = f"{met[-1].reference}; the motion ended after step {met[-1].step}: {ended}" if ended else met[-1].reference
    return [(met[i]._replace(reference=told), _starts(met, int(i))) for i in chosen]


def first_problem_of(stage: Scene, scheme: str) -> FrictionProblem:
    """The first problem that a scheme, by its name, meets in a scene; for the default scheme the one after its impacts."""
    return stage.problem() if scheme == DEFAULT_SCHEME else first_problem(stage, SCHEMES[scheme])


def _motion(stage: Scene, steps: int | None) -> tuple[list[Met], str]:
    """The problems of a motion that are worth solving, and why it ended before its time, if it did."""
    reference, met = Reference(), []
    try:
        for index, step in enumerate(simulate(stage, reference, steps=steps)):
            met += [
                Met(index, solved.phase, solved.problem, step.contacts, solved.impulse, str(reference))
                for solved in step.solved
                if _worth_solving(solved.problem)
            ]
    except NoReference as finding:
        return met, str(finding)
    return met, ""


def _worth_solving(problem: FrictionProblem) -> bool:
    return residual(problem, np.zeros((problem.contacts, problem.dimension))) > 0


def _starts(met: list[Met], i: int) -> dict[str, Array]:
    before = [j for j in range(i) if met[j].phase == met[i].phase]
    others = [j for j in range(len(met)) if j != i and met[j].phase == met[i].phase]
    starts = {}
    if before:
        starts[WARM] = _carried(met[before[-1]], met[i])
    if others:
        starts[SHUFFLED] = _carried(met[int(np.random.default_rng(i).choice(others))], met[i])
    return starts


def _carried(known: Met, wanted: Met) -> Array:
    """The impulses known, at the contacts wanted; zero at those that were not there."""
    assert known.contacts is not None
    assert wanted.contacts is not None
    assert known.impulse is not None
    there = {tuple(feature): impulse for feature, impulse in zip(known.contacts.feature.tolist(), known.impulse, strict=True)}
    nothing = np.zeros(wanted.problem.dimension)
    carried = [there.get(tuple(feature), nothing) for feature in wanted.contacts.feature.tolist()]
    return np.array(carried).reshape(wanted.problem.contacts, wanted.problem.dimension)


def _solution_set(problem: FrictionProblem) -> dict[str, Any]:
    """The shape of the set of solutions and of their velocities, where the problem is small enough to enumerate."""
    if problem.dimension != 2 or problem.contacts > MOST_COUNTED:
        return {"solutions": None, "outcomes": None}
    found = census_labels(problem)
    return {"solutions": found["solutions"], "outcomes": found["velocity_count"]}


def facts(source: Source, met: Met) -> Entry:
    """What a row says of a problem: harness.cells.rows.PROBLEM_FACTS."""
    problem = met.problem
    found = labels(problem)
    counted = _solution_set(problem)
    return {
        "problem": problem.hash,
        "scene": source.scene,
        "parameters": json.dumps(source.parameters, sort_keys=True),
        "step": met.step,
        "phase": met.phase,
        "reference": met.reference,
        "contacts": problem.contacts,
        "dimension": problem.dimension,
        "velocities": len(problem.free_velocity),
        "size": found.size,
        "rank": found.rank,
        "condition": found.condition,
        "redundancy": None if found.rank is None else problem.contacts * problem.dimension - found.rank,
        "pointedness": found.pointedness,
        "p0_margin": found.p0_margin,
        "mass_ratio": found.mass_ratio,
        "asymmetry": found.asymmetry,
        "indefiniteness": found.indefiniteness,
        "trivial": bool(found.trivial),
        **counted,
        "existence": _existence(problem, found.pointedness, counted["solutions"]),
        "sensitivity": _sensitivity(problem) if problem.contacts <= MOST_PERTURBED else None,
        "mode_distance": _mode_distance(problem),
    }


def lcp_facts(source: Source, lcp: LCP) -> Entry:
    """What a row says of a bare LCP, which has no contacts."""
    known: Entry = {"problem": lcp.hash, "scene": source.scene, "parameters": json.dumps(source.parameters, sort_keys=True)}
    known |= {"step": 0, "phase": "lcp", "reference": "", "size": lcp.size, "trivial": bool((lcp.q >= 0).all())}
    return dict.fromkeys(PROBLEM_FACTS) | known


def _existence(problem: FrictionProblem, pointedness: float, solutions: str | None) -> str:
    """Why a solution is known to exist: by theory, else by counting; "none" where counting finds none, "" if unknown."""
    known = existence(problem, pointedness <= POINTED)
    return known or ("" if solutions is None else "none" if solutions == "none" else "counted")


def _mode_distance(problem: FrictionProblem) -> float | None:
    if problem.dimension != 2 or not 0 < problem.contacts <= MOST_PERTURBED:
        return None
    try:
        return distance_to_next_mode(problem, Reference()(problem))
    except NoReference:
        return None


def _sensitivity(problem: FrictionProblem) -> float:
    """See problems.analysis.stability; infinity where the problem, or one near it, has no answer that holds."""
    try:
        return sensitivity(problem, Reference())
    except NoReference:
        return np.inf
