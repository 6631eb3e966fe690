"""Plans: the sources of problems, the solvers, tolerances, starts and limits of a run.

A source yields problems: steps of a scene recorded along a simulation with reference answers, an instance, or a file. A cell is
a unit of work with one row in the results. Cells are plain values that are sent to workers. A run is resumed by their keys.
"""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from typing import Any, ClassVar

from frictionbench.problems.catalogue import is_spatial
from frictionbench.problems.check import require
from frictionbench.results.conventions import COLD, DEFAULT_SCHEME, WARM
from frictionbench.results.maps import Map
from frictionbench.solvers import find
from frictionbench.solvers.interface import FINEST_TOL

NO_SETTINGS = ("expects", "options", "map_sources", "map_simulations")
MEMORY_LIMIT = 4 * 2**30  # bytes that a worker may allocate: more than the suites need, less than machines have per core


@dataclass(frozen=True)
class _Keyed:
    """A dataclass with a key that is a hash of its fields. kind: the prefix of the key."""

    kind: ClassVar[str]

    @property
    def key(self) -> str:
        fields = {name: "" if name == "problem" else part for name, part in asdict(self).items()}
        return f"{self.kind}-{sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()[:16]}"


@dataclass(frozen=True)
class Source(_Keyed):
    """Problems of one scene, an instance, or a problem in a file.

    scene: the name of the scene or instance (problems.instances), or of the set that a file belongs to. pick: the number of
    problems, spread over the motion; 0 for the scheme's first problem, which needs no solver. repeats: how often a short solve
    is timed, None for the default (harness.cells.timing). before, step: for a file that is a step of a sequence, the file of
    the previous step and the number of this one.
    """

    scene: str
    parameters: dict[str, Any] = field(default_factory=dict)
    pick: int = 0
    steps: int | None = None
    scheme: str = DEFAULT_SCHEME
    repeats: int | None = None
    file: str = ""
    before: str = ""
    step: int = 0

    kind = "source"


@dataclass(frozen=True)
class SolveCell(_Keyed):
    """One problem, one solver, one tolerance.

    problem: the content hash under which it is stored. origin: see `origin`; the key is computed from it instead of the hash,
    because the last bits of a recorded problem, and thus its hash, may differ between machines.
    """

    problem: str
    origin: str
    variant: str
    tol: float
    start: str = COLD

    kind, table = "solve", "solves"


@dataclass(frozen=True)
class SimulationCell(_Keyed):
    """One scene in closed loop with one solver."""

    scene: str
    parameters: dict[str, Any]
    variant: str
    tol: float
    scheme: str = DEFAULT_SCHEME
    steps: int | None = None

    kind, table = "simulation", "simulations"


@dataclass(frozen=True)
class BatchSource:
    """Problems of one scene or instance and size, which differ in drawn parameters (harness.cells.batch). count: how many."""

    scene: str
    parameters: dict[str, Any]
    count: int


@dataclass(frozen=True)
class BatchCell(_Keyed, BatchSource):
    """The problems of a batch, solved by one solver in one way (results.conventions.WAYS)."""

    variant: str
    way: str
    tol: float
    start: str = COLD

    kind, table = "batch", "batches"


Cell = SolveCell | SimulationCell | BatchCell


@dataclass(frozen=True)
class Plugin:
    """Solvers from outside this repository.

    source: see solvers.plugins. content: the hash of its content. solvers: the columns that describe each variant.
    """

    source: str
    content: str
    solvers: dict[str, dict[str, str]]


@dataclass(frozen=True)
class Plan:
    """The problems, solvers, tolerances and limits of a run. Times are in seconds, memory in bytes.

    spatial_solvers: those for problems and simulations in space; `solvers` if empty. simulation_tol: the one tolerance of all
    simulations. expects: the duration on two cores with one worker, as text; options: the command line's options that chose the
    plan (harness.plans.choose). Neither is a setting.

    map_sources, map_simulations: the problems and simulations at the maps' grid points so far (harness.maps). They are not
    settings, because they follow from the maps and from the rows found.
    """

    suite: str
    sources: tuple[Source, ...]
    solvers: tuple[str, ...]
    tolerances: tuple[float, ...]
    spatial_solvers: tuple[str, ...] = ()
    starts: tuple[str, ...] = (COLD,)
    simulations: tuple[Source, ...] = ()
    simulation_solvers: tuple[str, ...] = ()
    schemes: tuple[str, ...] = (DEFAULT_SCHEME,)
    maps: tuple[Map, ...] = ()
    batches: tuple[BatchSource, ...] = ()
    simulation_tol: float = 1e-8
    time_limit: float = 10.0
    simulation_limit: float = 60.0
    memory_limit: int = MEMORY_LIMIT
    plugins: tuple[Plugin, ...] = ()
    expects: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    map_sources: tuple[Source, ...] = ()
    map_simulations: tuple[SimulationCell, ...] = ()

    def __post_init__(self) -> None:
        require(bool(self.solvers), "solver", "none is given")
        require(bool(self.tolerances), "tol", "none is given")
        for tol in self.tolerances:
            require(0 < tol < 1, "tol", f"must lie between 0 and 1, got {tol}")
        require(0 < self.time_limit < float("inf"), "time-limit", f"must be positive, got {self.time_limit}")

    def limit(self, cell: Cell) -> float:
        """Return the time limit of a cell, s."""
        return self.simulation_limit if isinstance(cell, SimulationCell) else self.time_limit

    def settings(self) -> dict[str, Any]:
        """Return the plan as plain values for the manifest. Two runs with the same settings have the same cells."""
        return {name: value for name, value in json.loads(json.dumps(asdict(self))).items() if name not in NO_SETTINGS}

    def solve_cells(self, records: Iterable[dict[str, Any]]) -> list[SolveCell]:
        """Return a cell for every problem, solver, available start and tolerance, with the loosest tolerance first."""
        return [
            SolveCell(record["problem"], origin(record), variant, tol, start)
            for record in records
            for variant in self.lineup(record["dimension"])
            for start in self.starts
            if start in record["starts"]
            for tol in self._tolerances(variant)
        ]

    def _tolerances(self, variant: str) -> list[float]:
        """Return the tolerances, loosest first. Of several, one too tight for single precision adds the tightest it allows."""
        ours = len(self.tolerances) > 1 and not plugin_of(variant, self.plugins)
        finest = FINEST_TOL[find(variant)[0].precision] if ours else 0.0
        return sorted({*self.tolerances, *(finest for tol in self.tolerances if tol < finest)}, reverse=True)

    def simulation_cells(self) -> list[SimulationCell]:
        """Return a cell for every simulation, scheme and solver, and those at the maps' grid points."""
        simulated = [
            SimulationCell(simulation.scene, simulation.parameters, variant, self.simulation_tol, scheme, simulation.steps)
            for simulation in self.simulations
            for scheme in self.schemes
            for variant in (self.lineup(3) if is_spatial(simulation.scene) else self.simulation_solvers)
        ]
        return [*simulated, *self.map_simulations]

    def batch_cells(self) -> list[BatchCell]:
        """Return a cell for every batch, solver, way and tolerance; packed batches are also started warm if possible."""
        return [
            BatchCell(batch.scene, batch.parameters, batch.count, variant, way, tol, start)
            for batch in self.batches
            for tol in sorted(self.tolerances, reverse=True)
            for variant in self.lineup(3 if is_spatial(batch.scene) else 2)
            for way, start in self._ways(variant)
        ]

    def _ways(self, variant: str) -> list[tuple[str, str]]:
        """Return the ways in which a solver solves a batch, and their starts: all for a plug-in, which is not imported here."""
        ways = [("calls", COLD), ("packed", COLD), ("list", COLD), ("packed", WARM)]
        if plugin_of(variant, self.plugins):
            return ways
        info, instance = find(variant)
        packed = ways if info.warm_start else ways[:3]
        return packed if hasattr(instance, "solve_many") else ways[:1]

    def lineup(self, dimension: int | None) -> tuple[str, ...]:
        """Return the solvers for problems of this dimension, which is None for a bare LCP."""
        return (self.spatial_solvers if dimension == 3 else ()) or self.solvers

    @property
    def variants(self) -> tuple[str, ...]:
        """Return all solvers of problems and simulations, each once."""
        return tuple(dict.fromkeys((*self.solvers, *self.spatial_solvers, *self.simulation_solvers)))


def plugin_of(variant: str, plugins: tuple[Plugin, ...]) -> Plugin | None:
    """Return the plug-in that a variant belongs to, or None for our own."""
    return next((plugin for plugin in plugins if variant in plugin.solvers), None)


def owner(variant: str, plugins: tuple[Plugin, ...]) -> str:
    """Return the source and solver name of the plug-in that a variant belongs to, or an empty text for our own."""
    plugin = plugin_of(variant, plugins)
    return f"{plugin.source} {plugin.solvers[variant]['solver']}" if plugin else ""


def origin(record: dict[str, Any]) -> str:
    """Return the origin of a problem: scene, parameters, step and phase."""
    return f"{record['scene']} {record['parameters']} {record['step']} {record['phase']}"
