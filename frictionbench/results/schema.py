"""The three tables of a run: type, unit and meaning of every column.

    solves        a row per cell: one problem, solver, start and tolerance
    simulations   a row per scene, scheme and solver, run in closed loop
    batches       a row per batch of small problems, solver, way to solve them all, start and tolerance

Rows are in the order of the run's plan, or sorted by key if the run has not finished. Lists hold repeats or curves. The columns
`parameters` and `work` hold JSON. A number that was not measured is null. tools/columns.py makes docs/columns.md from them.
"""

import re
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import pyarrow as pa

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.conventions import WAYS

SCHEMA_VERSION = 3  # of files and columns; folders and baselines of another version are refused
TYPES = {"text": pa.string(), "real": pa.float64(), "whole": pa.int64(), "flag": pa.bool_(), "reals": pa.list_(pa.float64())}
VERDICTS = "; ".join(f"{each}: {each.meaning}" for each in Verdict)

# One entry per column: name, type, unit and meaning. An indented line continues the meaning.
_CELL = f"""
key                text      identity of the cell; the same cell of another run has the same key
scene              text      name of the scene, or of the collection that a recorded problem comes from
parameters         text      the scene's parameters, a JSON object
solver             text      name of the solver
variant            text      name and settings of the solver in the notation of the command line
family             text      family of methods
model              text      the model that the solver solves: coulomb, lcp, relaxation or regularised
members            text      the solvers that a portfolio may run, separated by commas; empty for a single method
version            text      version of the library that implements the method
tol                real  1   requested residual
time_limit         real  s   enforced limit on form, setup and solve together
verdict            text      result of the verification: {VERDICTS}
reason             text      explanation of the verdict, if any
host               text      machine that ran the cell
core               whole     processor core that ran the cell alone
core_wait          real  s   time for which the process was runnable but its core ran another one
disturbed          flag      no dedicated core, or core_wait above 2 % of the timed seconds
wall_time          real  s   duration of the cell including verification and repeats, excluding loading and compilation
overhead           real  s   part of wall_time outside form, setup and solve; of a simulation, verification and recording
peak_memory        real  B   largest resident memory of the process during the cell
"""
_PROBLEM = """
problem            text      content hash of the problem
step               whole     number of the time step in which the problem occurs
phase              text      step, compression or decompression, with the scheme unless it is the default
reference          text      solvers of the verified reference answers of the preceding steps, and why the motion ended early
contacts           whole     number of contacts
dimension          whole     2 planar, 3 spatial
velocities         whole     number of velocities
size               whole     unknowns of the friction LCP, in space with 8 facets
rank               whole     rank of the Delassus matrix W
condition          real  1   condition number of W on its range
redundancy         whole     number of rows of W minus its rank
pointedness        real  1   0 if the friction cone is pointed; else the size of impulses in it that cancel
p0_margin          real  1   least (a - mu |b|)/a over the contacts' blocks of W; below 0 a contact's own LCP is not P0
mass_ratio         real  1   largest effective mass at a contact over the smallest
largest_friction   real  1   largest coefficient of friction
asymmetry          real  1   largest |W - W'| over the largest |W|, for problems given by W; 0 for mechanical ones
indefiniteness     real  1   estimate of the most negative eigenvalue of W over the largest, for problems given by W
islands            whole     number of connected components of the contact graph, between which no velocity is transmitted
island_ratio       real  1   largest over smallest unit of velocity of a contact; 1 if nothing moves
limits             whole     how many of the contacts are limits of joints
dry_friction       whole     how many of the contacts are dry friction of joints
trivial            flag      no contact, no friction, or zero impulses are the answer
idle               flag      friction is not needed: the answer without friction satisfies Coulomb's law to 1e-8
solutions          text      shape of the set of solutions: none, one, convex, isolated, not convex; null if not enumerated
outcomes           whole     number of distinct velocities among the solutions; null if not enumerated or infinite
existence          text      proof that a solution exists: gaps, pointed (of LCPs), counted (enumeration); none: proof of none
proved_infeasible  flag      proof that contacts or joints contradict each other (Farkas); sought if there is no reference
sensitivity        real  1   relative change of the solution's velocities over that of q; large for ill-posed problems
mode_distance      real  1   distance of a solution from the nearest change of mode, as a relative velocity; 0 on a tie
"""
_SOLVES = """
start              text      cold (zero), warm (impulses of the previous problem) or shuffled (those of another step)
status             text      status reported by the solver
claimed            flag      the solver reports that it solved the problem
residual           real  1   verified residual of the exact problem, as a relative contact velocity
model_residual     real  1   verified residual of the solver's own model
residual_floor     real  1   bound on the rounding error of the residual
fclib_error        real      FCLIB's error, for comparison with published work
backward_error     real  1   smallest relative change of (q, mu) for which the answer is exact
energy_defect      real  1   absolute defect of the energy balance over the kinetic energy of the free motion
velocity_error     real  1   |v - v*| / |v* - v_0| in the norm of the mass; v* of the refined reference answer, v_0 without
                             impulses. An error if the problem has one outcome; null without a reference that changes v
outcome_distance   real  1   velocity_error of the answer refined to rounding; other outcomes differ in it by more than 1e-3
mode               text      state of each contact in the answer: o open, s sticking, l, r sliding; null if too many
work               text      deterministic counters, a JSON object
first_time         real  s   form, setup and solve of the first call; null if something was compiled or loaded in it
form_time          real  s   median of form_times: conversion of the problem to the method's form
setup_time         real  s   median of setup_times: preparation by the method or its library
solve_time         real  s   median of solve_times: the rest of the call
clock_time         real  s   median of the solve time measured by the library itself, if it does
call_time          real  s   median of setup and solve with transfer, of a library in another process with its own clock
form_times         reals s   form time of every repeat, in order
setup_times        reals s   setup time of every repeat, in order
solve_times        reals s   solve time of every repeat, in order
"""
_SIMULATIONS = """
scheme             text      time-stepping scheme
steps              whole     steps planned
steps_done         whole     steps taken
problems           whole     number of friction problems
unsolved           whole     number of problems whose verified residual exceeds the tolerance
worst_residual     real  1   largest verified residual
worst_energy_defect real  1   largest absolute defect of the energy balance over the scene's energy scale
energy_scale       real  J   largest kinetic energy plus largest change of potential energy
energy_drift       real  1   energy at the end minus energy at the start, over the energy scale
energy_rise        real  1   largest increase of energy in one step, over the energy scale
worst_penetration  real  m   largest penetration of two bodies
path_error         real  m   largest distance of a centre of mass from the scene's closed form; null without one
contact_free_steps whole     number of steps without any contact
solver_time        real  s   form, setup and solve, summed over all problems
times              reals s   time at the end of each step
energies           reals J   kinetic plus potential energy at these times
penetrations       reals m   largest penetration at these times
work               text      deterministic counters, summed over the problems, a JSON object
"""
_BATCHES = f"""
way                text      how all problems are solved: {"; ".join(f"{way}: {means}" for way, means in WAYS.items())}
start              text      cold (zero) or warm (impulses of the same problems at a smaller push)
dimension          whole     2 planar, 3 spatial
contacts           whole     number of contacts of each problem
problems           whole     number of problems
active             real  1   share of the contacts that bear in the answers of `base`
idle               real  1   share of problems, of a sample, whose answer without friction satisfies Coulomb's law
verified           real  1   share of problems whose verified residual is within the tolerance
residual           real  1   largest verified residual
work               text      deterministic counters, summed over the problems, a JSON object
times              reals s   processor's time, or the duration if it waited, over the number of problems, of each round
base               text      solver of the single calls to which rates are relative
base_times         reals s   the same of such a single call, measured in turn with `times`
"""


class Column(NamedTuple):
    """One column of a table. unit: in SI, "1" for a ratio, empty if it has none."""

    name: str
    type: pa.DataType
    unit: str
    meaning: str


def cut(text: str, *places: int) -> Iterator[list[str]]:
    """Split the lines of a text table into entries, which begin at columns 0 and `places`; indented lines continue the last."""
    for line in re.sub(r"\n +", " ", text.strip()).splitlines():
        yield [line[start:end].strip() for start, end in pairwise((0, *places, None))]


def _columns(*texts: str) -> tuple[Column, ...]:
    lines = (line for text in texts for line in cut(text, 19, 25, 29))
    return tuple(Column(name, TYPES[kind], unit, meaning) for name, kind, unit, meaning in lines)


SOLVES = _columns(_CELL, _PROBLEM, _SOLVES)
PROBLEM_FACTS = ("scene", "parameters", *(column.name for column in _columns(_PROBLEM)))  # the columns that describe a problem
TABLES = {"solves": SOLVES, "simulations": _columns(_CELL, _SIMULATIONS), "batches": _columns(_CELL, _BATCHES)}


def arrow_schema(table: str) -> pa.Schema:
    """Return the Arrow schema of a table, with units and meanings as field metadata."""
    return pa.schema([pa.field(c.name, c.type, metadata={"unit": c.unit, "meaning": c.meaning}) for c in TABLES[table]])
