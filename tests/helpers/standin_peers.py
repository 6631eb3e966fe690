"""Stand-ins for outside libraries in a child process; each must cost its cell and leave the right row, and no process."""

from pathlib import Path

from frictionbench.problems.check import require
from frictionbench.solvers import Answer, Status, solver
from frictionbench.solvers.outside.children.child import child

SCRIPT = str(Path(__file__).with_name("standin_child.py"))
KINDS = ("abort", "exit", "hang", "leak", "child", "print", "slow", "big")


@solver("peer", family="bad", model="coulomb", variants=tuple(f"does={kind}" for kind in KINDS))
class Peer:
    """A library that misbehaves on more than one contact."""

    does: str = "slow"

    def __post_init__(self):
        require(self.does in KINDS, "does", "unknown")

    def solve(self, problem, tol, limit, start=None):
        found = child(SCRIPT).ask(do=self.does if problem.contacts > 1 else "", n=2 * problem.contacts)
        impulse = found["r"].reshape(problem.contacts, 2)
        return Answer(impulse, Status.SOLVED, clock=found["clock"])


@solver("nowhere", family="bad", model="coulomb", needs=("no-such-distribution", "no.such.module@/usr/bin/python3"))
class Nowhere:
    """Needs what nobody has."""
