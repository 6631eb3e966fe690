"""The two tables a run leaves: every column's type, unit and meaning.

    solves   a row per cell: one problem, one solver, one tolerance
    simulations   a row per scene, scheme and solver run in closed loop

Lists hold raw repeats or curves. Text columns named `parameters` and `work` hold JSON objects. A number that was not
measured is null. docs/columns.md is made from this file:

    python -m frictionbench.results.schema > docs/columns.md
"""

from typing import NamedTuple

import pyarrow as pa

from frictionbench.results.verdicts import Verdict

VERSION = 2  # of files and columns; folders and baselines of another version are refused


class Column(NamedTuple):
    """One column of a table."""

    name: str
    type: pa.DataType
    unit: str
    meaning: str


_text, _real, _whole, _flag, _reals = pa.string(), pa.float64(), pa.int64(), pa.bool_(), pa.list_(pa.float64())

_CELL = (
    Column("key", _text, "", "identity of the cell; the same cell of another run has the same key"),
    Column("scene", _text, "", "name of the scene, or of the set a recorded problem comes from"),
    Column("parameters", _text, "", "the scene's parameters, a JSON object"),
    Column("solver", _text, "", "name of the solver"),
    Column("variant", _text, "", "name and settings, as the command line takes them"),
    Column("family", _text, "", "family of methods"),
    Column("model", _text, "", "what the solver solves: coulomb, lcp or relaxation"),
    Column("members", _text, "", "the solvers that a portfolio may run, separated by commas; empty for a single method"),
    Column("version", _text, "", "version of the library the method comes from"),
    Column("tol", _real, "1", "residual asked for"),
    Column("time_limit", _real, "s", "limit on form, setup and solve together, enforced"),
    Column("verdict", _text, "", "what the harness found: " + "; ".join(f"{each}: {each.meaning}" for each in Verdict)),
    Column("reason", _text, "", "why, where the verdict needs one"),
    Column("host", _text, "", "machine that ran the cell"),
    Column("core", _whole, "", "processor core that ran the cell alone"),
    Column("core_wait", _real, "s", "time the process was ready to run, within its calls, while its core ran something else"),
    Column("disturbed", _flag, "", "no core of its own, or it waited for it for more than a fiftieth of the time"),
    Column("load", _reals, "1", "the machine's load average, before and after"),
    Column("clock", _reals, "Hz", "the core's clock frequency, before and after, where the machine tells"),
    Column("wall_time", _real, "s", "the whole cell, verification and repeats included, loading and compiling not"),
    Column(
        "overhead",
        _real,
        "s",
        "of it, the harness's own: all but form, setup and solve; of a simulation, verifying and recording",
    ),
    Column("peak_memory", _real, "B", "largest resident memory of the process during the cell"),
)

SOLVES = (
    *_CELL,
    Column("problem", _text, "", "content hash of the problem"),
    Column("step", _whole, "", "time step the problem comes from"),
    Column("phase", _text, "", "step, compression or decompression"),
    Column("reference", _text, "", "whose verified answers moved the scene up to the problem, and why the motion ended early"),
    Column("contacts", _whole, "", "number of contacts"),
    Column("dimension", _whole, "", "2 planar, 3 spatial"),
    Column("velocities", _whole, "", "number of velocities"),
    Column("size", _whole, "", "unknowns of the friction LCP"),
    Column("rank", _whole, "", "rank of the Delassus matrix W"),
    Column("condition", _real, "1", "condition of W on its range"),
    Column("redundancy", _whole, "", "rows of W less its rank"),
    Column("pointedness", _real, "1", "0 where the friction cone is pointed; else the size of impulses that cancel"),
    Column("p0_margin", _real, "1", "least (a - mu |b|)/a of a contact's block of W; below 0 that contact alone is not P0"),
    Column("mass_ratio", _real, "1", "largest effective mass at a contact over the smallest"),
    Column("asymmetry", _real, "1", "largest |W - W'| over the largest |W|, where W is what is known; 0 for mechanics"),
    Column("indefiniteness", _real, "1", "most negative eigenvalue of W over the largest, as far as seen, where W is known"),
    Column("trivial", _flag, "", "no active friction, or the unconstrained answer is the answer"),
    Column("solutions", _text, "", "shape of the set of solutions: none, one, convex, isolated, not convex; null if too large"),
    Column("outcomes", _whole, "", "distinct post-velocities among the solutions; null if too many to count"),
    Column("existence", _text, "", "why a solution is known: gaps only, pointed cone, counted; none where counting finds none"),
    Column("sensitivity", _real, "1", "change of the solution's velocities over a small change of q; large where ill-posed"),
    Column("mode_distance", _real, "1", "of a solution from the next change of mode, as a relative velocity; 0 on a tie"),
    Column("start", _text, "", "cold; warm from the problem before; shuffled, from another of the same motion"),
    Column("status", _text, "", "what the solver says: the name of its status"),
    Column("claimed", _flag, "", "the solver says it solved the problem"),
    Column("residual", _real, "1", "verified residual of the exact problem, in relative contact velocity"),
    Column("model_residual", _real, "1", "verified residual of the model the solver was given"),
    Column("residual_floor", _real, "1", "bound of what rounding alone may change of the residual"),
    Column("fclib_error", _real, "", "FCLIB's error, for comparison with published work"),
    Column("signorini", _real, "1", "defect of 0 <= u_n _|_ r_n >= 0, in relative contact velocity"),
    Column("dissipation", _real, "1", "defect of maximum dissipation: how far r_t is from what friction asks for"),
    Column("ncp", _real, "1", "defect of the cone's complementarity: r in K, u + mu |u_t| e_n in K*, and their product"),
    Column("backward_error", _real, "1", "smallest relative change of (q, mu) under which the answer is exact"),
    Column("energy_defect", _real, "1", "defect of the energy ledger over the free kinetic energy"),
    Column("mode", _text, "", "what the answer makes of each contact: o open, s sticking, l, r sliding; null if too many"),
    Column("work", _text, "", "deterministic counts, a JSON object"),
    Column("first_time", _real, "s", "form, setup and solve of the first call; null where it compiled or loaded something"),
    Column("form_time", _real, "s", "median of form_times: the problem written as what the method takes"),
    Column("setup_time", _real, "s", "median of setup_times: the method's or library's own preparation"),
    Column("solve_time", _real, "s", "median of solve_times"),
    Column("clock_time", _real, "s", "median of the library's own clock of its solve, where it keeps one"),
    Column("form_times", _reals, "s", "every repeat, in order"),
    Column("setup_times", _reals, "s", "every repeat, in order"),
    Column("solve_times", _reals, "s", "every repeat, in order"),
)

SIMULATIONS = (
    *_CELL,
    Column("scheme", _text, "", "time-stepping scheme"),
    Column("after_failure", _text, "", "what moves the bodies where the solver failed: its answer, velocity, relaxation"),
    Column("step_size", _real, "s", "h"),
    Column("steps", _whole, "", "steps planned"),
    Column("steps_done", _whole, "", "steps taken"),
    Column("problems", _whole, "", "friction problems met"),
    Column("unsolved", _whole, "", "problems whose verified residual missed the tolerance"),
    Column("most_contacts", _whole, "", "largest number of contacts in a problem"),
    Column("worst_residual", _real, "1", "largest verified residual"),
    Column("worst_energy_defect", _real, "1", "largest defect of the energy ledger over the scene's energy scale"),
    Column("energy_scale", _real, "J", "largest kinetic energy plus largest change of potential energy"),
    Column("energy_drift", _real, "1", "energy at the end less energy at the start, over the energy scale"),
    Column("energy_rise", _real, "1", "largest rise of energy in one step, over the energy scale"),
    Column("worst_penetration", _real, "m", "deepest overlap of two bodies"),
    Column("contact_free_steps", _whole, "", "steps without any contact"),
    Column("solver_time", _real, "s", "form, setup and solve, summed over all problems"),
    Column("times", _reals, "s", "time of each step's end"),
    Column("energies", _reals, "J", "kinetic and potential energy at these times"),
    Column("penetrations", _reals, "m", "deepest overlap at these times"),
)

TABLES = {"solves": SOLVES, "simulations": SIMULATIONS}


def arrow_schema(table: str) -> pa.Schema:
    """The Arrow schema of a table, units and meanings as field metadata."""
    columns = TABLES[table]
    return pa.schema([pa.field(c.name, c.type, metadata={"unit": c.unit, "meaning": c.meaning}) for c in columns])


PAGE = """# Columns

Made from the schema by `python -m frictionbench.results.schema`; a test compares the two. Schema version {version}; folders and
baselines of another version are refused.

A run writes two tables, `solves.parquet` and `simulations.parquet`; `frictionbench.read_results(DIR)` reads them as
`pandas.DataFrame`. Units are SI, 1 marks a ratio. A number that was not measured is null. Text columns named `parameters` and
`work` hold JSON objects.

## solves

A row per cell: one problem, one solver, one tolerance.

{solves}

## simulations

A row per scene, scheme and solver run in closed loop.

{simulations}
"""


def describe() -> str:
    """All columns with types, units and meanings, as a page of Markdown."""
    return PAGE.format(version=VERSION, **{name: _markdown(columns) for name, columns in TABLES.items()})


def _markdown(columns: tuple[Column, ...]) -> str:
    cells = [[f"`{c.name}`", _type(c.type), c.unit, c.meaning.replace("|", "\\|")] for c in columns]
    return "\n".join(f"| {' | '.join(row)} |" for row in [["column", "type", "unit", "meaning"], ["---"] * 4, *cells])


def _type(kind: pa.DataType) -> str:
    return f"list of {kind.value_type}" if pa.types.is_list(kind) else str(kind)


if __name__ == "__main__":
    print(describe(), end="")
