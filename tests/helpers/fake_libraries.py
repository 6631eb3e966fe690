"""Fake outside libraries in a child process that misbehave: a run must record the right verdict and leave no process."""

from pathlib import Path

from frictionbench.problems.check import require
from frictionbench.solvers import Answer, Status, solver
from frictionbench.solvers.outside.children.child import child

SCRIPT = str(Path(__file__).with_name("fake_library_child.py"))
KINDS = ("abort", "exit", "hang", "child", "print", "slow", "big")


@solver("fake_library", family="bad", model="coulomb", variants=tuple(f"does={kind}" for kind in KINDS))
class FakeLibrary:
    """A fake library that misbehaves in the given way on problems of more than one contact."""

    does: str = "slow"

    def __post_init__(self):
        require(self.does in KINDS, "does", "unknown")

    def solve(self, problem, tol, limit, start=None):
        found = child(SCRIPT).ask(do=self.does if problem.contacts > 1 else "", n=2 * problem.contacts)
        impulse = found["r"].reshape(problem.contacts, 2)
        return Answer(impulse, Status.SOLVED, clock=found["clock"])


@solver("missing_library", family="bad", model="coulomb", needs=("no-such-distribution", "no.such.module@/usr/bin/python3"))
class MissingLibrary(FakeLibrary):
    """Needs a distribution and a module that do not exist."""
