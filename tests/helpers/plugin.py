"""Write a plug-in file with code given by the test."""

from pathlib import Path

PLUGIN = """
from pathlib import Path
import numpy as np
from frictionbench.solvers import Answer, Status, solver

{first}

@solver("guest", family="test", model="coulomb", warm_start=True)
class Guest:
    \"\"\"Answers with zeros.\"\"\"

    factor: float = 0.0

    def solve(self, problem, tol, limit, start=None):
        {body}
        return Answer(np.full((problem.contacts, problem.dimension), self.factor), Status.STALLED)
"""


def write(path: Path, first: str = "", body: str = "pass") -> Path:
    path.parent.mkdir(exist_ok=True)
    path.write_text(PLUGIN.format(first=first, body=body), encoding="utf-8")
    return path
