"""A plan: where the problems come from, which solvers meet them, at which tolerances and limits.

A source yields problems (a scene's steps, recorded along a simulation with a reference solver; an instance; a file); a cell is
one unit of work with one row in the results. Cells are plain values: they travel to workers, and their keys make resuming work.
"""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from typing import Any

from frictionbench.problems import InputError
from frictionbench.problems.instances import instances
from frictionbench.results.conventions import COLD, DEFAULT_SCHEME, KEEP_ANSWER
from frictionbench.results.map_spec import Map

MOST_SHOWN = 100  # steps


@dataclass(frozen=True)
class Source:
    """Problems of one scene. pick: how many, spread over its motion; 0 for the first step's alone, met without a solver, as
    the scheme has it. repeats: how often a short solve is timed, the usual where None.

    Of an instance (problems.instances) `scene` is the name, of a problem in a file that of the set it belongs to. tolerances,
    time_limit: in place of the plan's.
    """

    scene: str
    parameters: dict[str, Any] = field(default_factory=dict)
    pick: int = 0
    steps: int | None = None
    scheme: str = DEFAULT_SCHEME
    repeats: int | None = None
    file: str = ""
    tolerances: tuple[float, ...] = ()
    time_limit: float | None = None

    @property
    def key(self) -> str:
        return _key("source", self)

    @property
    def moves(self) -> bool:
        """Whether there is a scene behind it that moves."""
        return not self.file and self.scene not in instances()


@dataclass(frozen=True)
class SolveCell:
    """One problem, one solver, one tolerance.

    problem: the content hash under which it is stored. origin: where it comes from; the key is made of that, for the last bits
    of a recorded problem, and so its hash, may differ between machines.
    """

    problem: str
    origin: str
    variant: str
    tol: float
    start: str = COLD

    table = "solves"

    @property
    def key(self) -> str:
        return _key("solve", replace(self, problem=""))


@dataclass(frozen=True)
class SimulationCell:
    """One scene in closed loop with one solver. after: how it continues after a failed step, see harness.cells.simulation."""

    scene: str
    parameters: dict[str, Any]
    variant: str
    tol: float
    scheme: str = DEFAULT_SCHEME
    steps: int | None = None
    after: str = KEEP_ANSWER

    table = "simulations"

    @property
    def key(self) -> str:
        return _key("simulation", self)


Cell = SolveCell | SimulationCell


@dataclass(frozen=True)
class Plugin:
    """Solvers from outside this repository: where from (see solvers.plugins), its content's hash, by variant what rows say."""

    source: str
    content: str
    solvers: dict[str, dict[str, str]]


@dataclass(frozen=True)
class Plan:
    """What a run does. Times in seconds, memory in bytes; the first tolerance of a simulation is its only one.

    map_sources, map_simulations: the problems and simulations at the maps' grid points so far (harness.run_maps). They are not
    settings, because they follow from the maps and from the rows found.
    """

    suite: str
    sources: tuple[Source, ...]
    solvers: tuple[str, ...]
    tolerances: tuple[float, ...]
    starts: tuple[str, ...] = (COLD,)
    simulations: tuple[Source, ...] = ()
    simulation_solvers: tuple[str, ...] = ()
    schemes: tuple[str, ...] = (DEFAULT_SCHEME,)
    after_failure: tuple[str, ...] = (KEEP_ANSWER,)
    maps: tuple[Map, ...] = ()
    simulation_tol: float = 1e-8
    time_limit: float = 10.0
    simulation_limit: float = 60.0
    memory_limit: int = 4 * 2**30
    plugins: tuple[Plugin, ...] = ()
    map_sources: tuple[Source, ...] = ()
    map_simulations: tuple[SimulationCell, ...] = ()

    def __post_init__(self) -> None:
        _check(bool(self.solvers), "solver", "none given")
        _check(bool(self.tolerances), "tol", "none given")
        _check(all(0 < tol < 1 for tol in self.tolerances), "tol", "must lie between 0 and 1")
        _check(0 < self.time_limit < float("inf"), "time-limit", "must be positive")

    def settings(self) -> dict[str, Any]:
        """The plan as plain values, for the manifest: two runs with the same settings do the same cells."""
        told = json.loads(json.dumps(asdict(self)))
        return {name: value for name, value in told.items() if name not in ("map_sources", "map_simulations")}

    def solve_cells(self, entries: Iterable[dict[str, Any]]) -> list[SolveCell]:
        """Every problem with every solver, start that it has, and tolerance, the loosest first."""
        return [
            SolveCell(entry["problem"], origin(entry), variant, tol, start)
            for entry in entries
            for variant in self.solvers
            for start in self.starts
            if start in entry["starts"]
            for tol in sorted(entry.get("tolerances") or self.tolerances, reverse=True)
        ]

    def simulation_cells(self) -> list[SimulationCell]:
        simulated = [
            SimulationCell(
                simulation.scene, simulation.parameters, variant, self.simulation_tol, scheme, simulation.steps, after
            )
            for simulation in self.simulations
            for scheme in self.schemes
            for variant in self.simulation_solvers
            for after in self.after_failure
        ]
        return [*simulated, *self.map_simulations]

    def owner(self, variant: str) -> str:
        """The solver from outside this repository that a variant is of, with its source; empty for our own."""
        return next((f"{p.source} {p.solvers[variant]['solver']}" for p in self.plugins if variant in p.solvers), "")

    @property
    def polygons(self) -> bool:
        """Whether polygons in place of the friction cone are compared."""
        return any("facets=" in variant for variant in self.solvers)

    def shown(self) -> list[Source]:
        """What to record for the eye: every simulation, and a short motion of each scene that none simulates."""
        simulated = {simulation.scene for simulation in self.simulations}
        others: dict[str, Source] = {}
        for source in self.sources:
            if source.moves and source.scene not in simulated:
                others.setdefault(source.scene, replace(source, steps=source.steps or MOST_SHOWN))
        return [*self.simulations, *others.values()]


def origin(entry: dict[str, Any]) -> str:
    """Where a problem comes from: scene, parameters, step and phase."""
    return f"{entry['scene']} {entry['parameters']} {entry['step']} {entry['phase']}"


def _check(condition: bool, field: str, complaint: str) -> None:
    if not condition:
        raise InputError(f"{field}: {complaint}")


def _key(kind: str, value: Source | SolveCell | SimulationCell) -> str:
    """A hash of what makes the value what it is; going on with the answer after a failure is not told, as ever."""
    told = {name: part for name, part in asdict(value).items() if (name, part) != ("after", KEEP_ANSWER)}
    return kind + "-" + sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:16]
