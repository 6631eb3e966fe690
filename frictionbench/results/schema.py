"""The three tables of a run: type, unit and meaning of every column.

    solves        a row per cell: one problem, solver, start and tolerance
    simulations   a row per scene, scheme, solver and way to continue after a failed step, run in closed loop
    batches       a row per batch of small problems, solver, way to solve them all, start and tolerance

Rows are in the order of the run's plan; while the run has not finished they are ordered by key. Lists hold single repeats or
curves. The text columns `parameters` and `work` hold JSON objects. A number that was not measured is null. docs/columns.md is
made from this file by tools/columns.py.
"""

from typing import NamedTuple

import pyarrow as pa

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.conventions import WAYS

SCHEMA_VERSION = 3  # of files and columns; folders and baselines of another version are refused


class Column(NamedTuple):
    """One column of a table. unit: SI, "1" for a ratio, empty for what has no unit."""

    name: str
    type: pa.DataType
    unit: str
    meaning: str


_text, _real, _whole, _flag, _reals = pa.string(), pa.float64(), pa.int64(), pa.bool_(), pa.list_(pa.float64())

_CELL = (
    Column("key", _text, "", "identity of the cell; the same cell of another run has the same key"),
    Column("scene", _text, "", "name of the scene, or of the collection that a recorded problem comes from"),
    Column("parameters", _text, "", "the scene's parameters, a JSON object"),
    Column("solver", _text, "", "name of the solver"),
    Column("variant", _text, "", "name and settings of the solver in the notation of the command line"),
    Column("family", _text, "", "family of methods"),
    Column("model", _text, "", "the model that the solver solves: coulomb, lcp, relaxation or regularised"),
    Column("members", _text, "", "the solvers that a portfolio may run, separated by commas; empty for a single method"),
    Column("version", _text, "", "version of the library that implements the method"),
    Column("tol", _real, "1", "requested residual"),
    Column("time_limit", _real, "s", "enforced limit on form, setup and solve together"),
    Column("verdict", _text, "", "result of the verification: " + "; ".join(f"{each}: {each.meaning}" for each in Verdict)),
    Column("reason", _text, "", "explanation of the verdict, if any"),
    Column("host", _text, "", "machine that ran the cell"),
    Column("core", _whole, "", "processor core that ran the cell alone"),
    Column("core_wait", _real, "s", "time for which the process was runnable but its core ran another one"),
    Column("disturbed", _flag, "", "no dedicated core, or core_wait above 2 % of the timed seconds"),
    Column("load", _reals, "1", "load average of the machine, before and after"),
    Column("clock", _reals, "Hz", "clock frequency of the core, before and after, where the machine reports it"),
    Column(
        "wall_time", _real, "s", "duration of the cell including verification and repeats, excluding loading and compilation"
    ),
    Column(
        "overhead", _real, "s", "part of wall_time outside form, setup and solve; of a simulation, verification and recording"
    ),
    Column("peak_memory", _real, "B", "largest resident memory of the process during the cell"),
)

SOLVES = (
    *_CELL,
    Column("problem", _text, "", "content hash of the problem"),
    Column("step", _whole, "", "number of the time step in which the problem occurs"),
    Column("phase", _text, "", "step, compression or decompression, with the scheme unless it is the default"),
    Column(
        "reference",
        _text,
        "",
        "solvers of the verified reference answers of the preceding steps, and why the motion ended early",
    ),
    Column("contacts", _whole, "", "number of contacts"),
    Column("dimension", _whole, "", "2 planar, 3 spatial"),
    Column("velocities", _whole, "", "number of velocities"),
    Column("size", _whole, "", "unknowns of the friction LCP"),
    Column("rank", _whole, "", "rank of the Delassus matrix W"),
    Column("condition", _real, "1", "condition number of W on its range"),
    Column("redundancy", _whole, "", "number of rows of W minus its rank"),
    Column("pointedness", _real, "1", "0 if the friction cone is pointed; else the size of impulses in it that cancel"),
    Column(
        "p0_margin", _real, "1", "least (a - mu |b|)/a over the contacts' blocks of W; below 0 a contact's own LCP is not P0"
    ),
    Column("mass_ratio", _real, "1", "largest effective mass at a contact over the smallest"),
    Column("largest_friction", _real, "1", "largest coefficient of friction"),
    Column("asymmetry", _real, "1", "largest |W - W'| over the largest |W|, for problems given by W; 0 for mechanical ones"),
    Column(
        "indefiniteness", _real, "1", "estimate of the most negative eigenvalue of W over the largest, for problems given by W"
    ),
    Column(
        "islands", _whole, "", "number of connected components of the contact graph, between which no velocity is transmitted"
    ),
    Column(
        "island_ratio",
        _real,
        "1",
        "largest over smallest unit of velocity of a contact, the largest closing speed in its island; 1 where nothing moves",
    ),
    Column("limits", _whole, "", "how many of the contacts are limits of joints"),
    Column("dry_friction", _whole, "", "how many of the contacts are dry friction of joints"),
    Column("trivial", _flag, "", "no contact, no friction, or zero impulses are the answer"),
    Column("idle", _flag, "", "friction is not needed: the answer without friction satisfies Coulomb's law to 1e-8"),
    Column("sticking", _whole, "", "number of contacts that stick in the reference answer; null without one"),
    Column("sliding", _whole, "", "number of contacts that slide in the reference answer; null without one"),
    Column("open", _whole, "", "number of contacts without impulse in the reference answer; null without one"),
    Column(
        "solutions", _text, "", "shape of the set of solutions: none, one, convex, isolated, not convex; null if not enumerated"
    ),
    Column("outcomes", _whole, "", "number of distinct velocities among the solutions; null if not enumerated"),
    Column(
        "existence",
        _text,
        "",
        "proof of existence of a solution: gaps or pointed (theorems), counted (enumeration); none: proved to be none",
    ),
    Column(
        "proved_infeasible",
        _flag,
        "",
        "contacts or joints contradict each other, proved (Farkas): no impulses have a residual of 1e-8; looked for where "
        "there is no reference answer",
    ),
    Column(
        "sensitivity", _real, "1", "relative change of the solution's velocities over that of q; large for ill-posed problems"
    ),
    Column(
        "mode_distance",
        _real,
        "1",
        "distance of a solution from the nearest change of mode, as a relative velocity; 0 on a tie",
    ),
    Column(
        "start",
        _text,
        "",
        "cold (zero), warm (impulses of the previous problem), shuffled (those of another step of the motion)",
    ),
    Column("status", _text, "", "status reported by the solver"),
    Column("claimed", _flag, "", "the solver reports that it solved the problem"),
    Column("residual", _real, "1", "verified residual of the exact problem, as a relative contact velocity"),
    Column("model_residual", _real, "1", "verified residual of the solver's own model"),
    Column("residual_floor", _real, "1", "bound on the rounding error of the residual"),
    Column("fclib_error", _real, "", "FCLIB's error, for comparison with published work"),
    Column("signorini", _real, "1", "defect of 0 <= u_n _|_ r_n >= 0, as a relative contact velocity"),
    Column("dissipation", _real, "1", "distance of r_t from the maximum-dissipation solution"),
    Column("ncp", _real, "1", "defect of the cone complementarity: r in K, u + mu |u_t| e_n in K*, and their product"),
    Column("backward_error", _real, "1", "smallest relative change of (q, mu) for which the answer is exact"),
    Column("energy_defect", _real, "1", "defect of the energy balance over the kinetic energy of the free motion"),
    Column(
        "velocity_error",
        _real,
        "1",
        "|v - v*| / |v* - v_0| in the metric of the mass, v* of the refined reference answer, v_0 without impulses; an error "
        "where the problem has one outcome, null without a reference",
    ),
    Column(
        "outcome_distance",
        _real,
        "1",
        "the same of the answer refined to rounding, from a residual of 1e-4: distances more than 1e-3 apart are of different "
        "outcomes; null where it is not refined that far",
    ),
    Column("mode", _text, "", "state of each contact in the answer: o open, s sticking, l, r sliding; null if too many"),
    Column("work", _text, "", "deterministic counters, a JSON object"),
    Column("first_time", _real, "s", "form, setup and solve of the first call; null if something was compiled or loaded in it"),
    Column("form_time", _real, "s", "median of form_times: conversion of the problem to the method's form"),
    Column("setup_time", _real, "s", "median of setup_times: preparation by the method or its library"),
    Column("solve_time", _real, "s", "median of solve_times: the rest of the call"),
    Column("clock_time", _real, "s", "median of the solve time measured by the library itself, if it does"),
    Column(
        "call_time",
        _real,
        "s",
        "median of setup and solve, transfer included, of a library in another process, whose solve_time is its clock",
    ),
    Column("form_times", _reals, "s", "form time of every repeat, in order"),
    Column("setup_times", _reals, "s", "setup time of every repeat, in order"),
    Column("solve_times", _reals, "s", "solve time of every repeat, in order"),
)

SIMULATIONS = (
    *_CELL,
    Column("scheme", _text, "", "time-stepping scheme"),
    Column("after_failure", _text, "", "how the motion continues after a failed step: answer, velocity or relaxation"),
    Column("step_size", _real, "s", "time step h"),
    Column("steps", _whole, "", "steps planned"),
    Column("steps_done", _whole, "", "steps taken"),
    Column("problems", _whole, "", "number of friction problems"),
    Column("unsolved", _whole, "", "number of problems whose verified residual exceeds the tolerance"),
    Column("most_contacts", _whole, "", "largest number of contacts in a problem"),
    Column("worst_residual", _real, "1", "largest verified residual"),
    Column("worst_energy_defect", _real, "1", "largest defect of the energy balance over the scene's energy scale"),
    Column("energy_scale", _real, "J", "largest kinetic energy plus largest change of potential energy"),
    Column("energy_drift", _real, "1", "energy at the end minus energy at the start, over the energy scale"),
    Column("energy_rise", _real, "1", "largest increase of energy in one step, over the energy scale"),
    Column("worst_penetration", _real, "m", "largest penetration of two bodies"),
    Column("path_error", _real, "m", "largest distance of a centre of mass from the scene's closed form; null without one"),
    Column("contact_free_steps", _whole, "", "number of steps without any contact"),
    Column("solver_time", _real, "s", "form, setup and solve, summed over all problems"),
    Column("times", _reals, "s", "time at the end of each step"),
    Column("energies", _reals, "J", "kinetic plus potential energy at these times"),
    Column("penetrations", _reals, "m", "largest penetration at these times"),
)

BATCHES = (
    *_CELL,
    Column("way", _text, "", "how all problems are solved: " + "; ".join(f"{way}: {means}" for way, means in WAYS.items())),
    Column("start", _text, "", "cold (zero) or warm (impulses of the same problems at a smaller push)"),
    Column("dimension", _whole, "", "2 planar, 3 spatial"),
    Column("contacts", _whole, "", "number of contacts of each problem"),
    Column("problems", _whole, "", "number of problems"),
    Column("active", _real, "1", "share of the contacts that bear in the answers of `base`"),
    Column("idle", _real, "1", "share of problems, of a sample, whose answer without friction satisfies Coulomb's law"),
    Column("verified", _real, "1", "share of problems whose verified residual is within the tolerance"),
    Column("residual", _real, "1", "largest verified residual"),
    Column("work", _text, "", "deterministic counters, summed over the problems, a JSON object"),
    Column("times", _reals, "s", "processor's time, or the duration if it waited, over the number of problems, of each round"),
    Column("base", _text, "", "solver of the single calls to which rates are relative"),
    Column("base_times", _reals, "s", "the same of such a single call, measured in turn with `times`"),
    Column(
        "problem_times", _reals, "s", "the same of each problem of a sample, solved many times over; null if results are reused"
    ),
    Column("threads", _whole, "", "number of threads, on as many cores; null where they were not tried"),
    Column("gain", _real, "1", "rate on them over that on one, by the wall's clock; null where other processes ran meanwhile"),
)

TABLES = {"solves": SOLVES, "simulations": SIMULATIONS, "batches": BATCHES}


def arrow_schema(table: str) -> pa.Schema:
    """The Arrow schema of a table, units and meanings as field metadata."""
    columns = TABLES[table]
    return pa.schema([pa.field(c.name, c.type, metadata={"unit": c.unit, "meaning": c.meaning}) for c in columns])
