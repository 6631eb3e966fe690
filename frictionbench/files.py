"""Problems read from files and written to them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from frictionbench.problems import LCP, FrictionProblem, InputError, check, recorded
from frictionbench.problems.check import require
from frictionbench.problems.friction import require_problem
from frictionbench.problems.recorded import fclib, native
from frictionbench.problems.recorded.native import EngineStep


def load(path: str | Path) -> FrictionProblem | LCP:
    """Read a problem from a file.

    path: an .npz written by `save`, a plain .npz of arrays (W, q, mu, d or M, N, T, mu, v; an LCP's M, q), FCLIB's HDF5,
    Siconos' text or ContactBench's .npz. The format is recognised by the content, whatever the file's name.

    Returns a FrictionProblem, or an LCP if the file holds a bare one. Pickled objects are never loaded.
    Limits: 4 GiB unpacked for an .npz, 512 MiB for HDF5 and for text.
    Errors: InputError naming path, or the file and the field that is missing or cannot be used, or that is too large.

    >>> import numpy as np
    >>> np.savez("problem.npz", W=np.eye(2), q=[-1.0, 0.3], mu=0.5, d=2)  # u = W r + q, the normal first
    >>> load("problem.npz").q.tolist()
    [-1.0, 0.3]
    >>> np.savez("lcp.npz", M=np.eye(2), q=[-1.0, 0.3])  # w = M z + q
    >>> load("lcp.npz")
    LCP(2 unknowns)
    """
    return recorded.read(check.path("path", path))


def load_step(path: str | Path) -> EngineStep:
    """Read a step of an engine: the problem, and the engine's answer.

    path: an .npz written by `save` with impulses, or by a capture.

    Returns an EngineStep. Limits: as for `load`.
    Errors: InputError as for `load`, and if the file holds no impulses of an engine.

    >>> import numpy as np
    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=1).problem()
    >>> fb.save(problem, "step.npz", impulse=np.zeros((2, 2)), notes={"soft contacts": 0.01})
    >>> load_step("step.npz")
    EngineStep(2 contacts in the plane, 3 velocities, soft contacts 1.00 %)
    """
    return native.load_step(check.path("path", path))


def save(
    problem: FrictionProblem | LCP,
    path: str | Path,
    *,
    impulse: Any = None,
    notes: Mapping[str, float] | None = None,
    step: float | None = None,
) -> None:
    """Write a problem to a file that `load` reads, or a step of an engine, which `load_step` reads.

    path: its suffix selects the format. .npz: our own, every field of a FrictionProblem or the M and q of an LCP, bit for bit.
    .hdf5 or .h5: FCLIB's, its local form if only W is known, otherwise its global form.
    impulse: (contacts, d), N s, the normal first: the impulses that an engine used in this step; only in an .npz.
    notes: effects in the step that the problem does not express, by name, with their shares of the impulse, from 0 to 1.
    step: the length of the engine's step, s, if the problem's bias is the gap divided by it.

    An existing file is replaced. Errors: InputError for another suffix, and if FCLIB's format cannot hold the problem (an LCP,
    a friction bias); InputError naming impulse, notes or step; OSError if the file cannot be written.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2).problem()
    >>> save(problem, "stack.npz")
    >>> load("stack.npz").hash == problem.hash
    True
    >>> save(problem, "step.npz", impulse=fb.solve(problem, "lemke").impulse, step=0.01)
    """
    require_problem(problem)
    path = check.path("path", path)
    require(path.suffix in (".npz", *fclib.SUFFIXES), "path", f"{path} must end in .npz, {' or '.join(fclib.SUFFIXES)}")
    if impulse is not None or notes or step is not None:
        require(impulse is not None, "impulse", "is missing; notes and step describe a step whose impulses an engine found")
        if isinstance(problem, LCP):
            raise InputError("problem: an LCP has no contacts, whose impulses an engine could have found")
        require(path.suffix == ".npz", "path", f"{path} must end in .npz, which alone holds the impulses of an engine")
        native.save(EngineStep(problem, impulse, notes or {}, step), path)
    elif path.suffix == ".npz":
        native.save(problem, path)
    elif isinstance(problem, LCP):
        raise InputError("problem: FCLIB's format does not hold LCPs; write an .npz")
    else:
        fclib.write(problem, path)
