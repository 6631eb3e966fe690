"""Many friction problems of any sizes, dimensions and kinds, packed for compiled loops."""

from collections.abc import Iterable, Iterator

import numpy as np

from frictionbench.problems.check import require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.packed import Packed, pack
from frictionbench.problems.rows import Index64


class Batch:
    """Friction problems packed once, to be solved by `solve_many` as often as wanted.

    problems: FrictionProblems, of any sizes; in the plane, in space, or both. Errors: InputError naming the entry that is none.

    groups: the packed problems of the plane and of space, with their numbers. Those with joints are in none: they are solved
    one by one. dimension (N,): that of the contacts. first (N+1,): where the impulses of each problem begin in a flat array.

    >>> import frictionbench as fb
    >>> batch = fb.Batch(fb.scene("stack", blocks=n, push=1.0).problem() for n in (1, 2, 3))
    >>> len(batch), batch.first.tolist()
    (3, [0, 4, 12, 24])
    """

    problems: tuple[FrictionProblem, ...]
    groups: tuple[tuple[Index64, Packed], ...]
    dimension: Index64
    first: Index64

    def __init__(self, problems: Iterable[FrictionProblem]) -> None:
        require(isinstance(problems, Iterable), "problems", f"must be a sequence of FrictionProblems, got {type(problems)}")
        self.problems = tuple(problems)
        members: dict[int, list[int]] = {}
        sizes = []
        for k, problem in enumerate(self.problems):
            require(isinstance(problem, FrictionProblem), f"problems[{k}]", f"must be a FrictionProblem, got {type(problem)}")
            sizes.append(problem.contacts * problem.dimension)
            if not (problem.mechanical and len(problem.joint_bias)):
                members.setdefault(problem.dimension, []).append(k)
        numbers = [np.array(which) for which in members.values()]
        self.groups = tuple((which, pack([self.problems[k] for k in which])) for which in numbers)
        self.dimension = np.array([problem.dimension for problem in self.problems], np.int64)
        self.first = np.concatenate([[0], np.cumsum(np.array(sizes, np.int64))])

    def __len__(self) -> int:
        return len(self.problems)

    def __iter__(self) -> Iterator[FrictionProblem]:
        return iter(self.problems)

    def __repr__(self) -> str:
        return f"Batch({len(self)} problems)"
