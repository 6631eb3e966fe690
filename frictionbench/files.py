"""Problems read from files and written to them."""

from pathlib import Path

from frictionbench.problems import LCP, FrictionProblem, InputError, recorded
from frictionbench.problems.friction import require_problem
from frictionbench.problems.recorded import fclib, own

HDF5_SUFFIXES = (".hdf5", ".h5")


def load(path: str | Path) -> FrictionProblem | LCP:
    """Read a problem from a file.

    path: an .npz written by `save`, a plain .npz of arrays (W, q, mu, d or M, N, T, mu, v; an LCP's M, q), FCLIB's HDF5,
    Siconos' text or ContactBench's .npz. The format is recognised by the content, whatever the file's name.

    Returns a FrictionProblem, or an LCP where the file holds a bare one. Pickled objects are never loaded.
    Limits: 4 GiB unpacked for an .npz, 512 MiB for HDF5 and for text.
    Errors: InputError naming the file and the field that is missing or cannot be used, or that is too large.

    >>> import numpy as np
    >>> np.savez("problem.npz", W=np.eye(2), q=[-1.0, 0.3], mu=0.5, d=2)  # u = W r + q, the normal first
    >>> load("problem.npz").q.tolist()
    [-1.0, 0.3]
    >>> np.savez("lcp.npz", M=np.eye(2), q=[-1.0, 0.3])  # w = M z + q
    >>> load("lcp.npz")
    LCP(2 unknowns)
    """
    return recorded.read(Path(path))


def save(problem: FrictionProblem | LCP, path: str | Path) -> None:
    """Write a problem to a file that `load` reads.

    path: its suffix selects the format. .npz: our own, every field of a FrictionProblem or the M and q of an LCP, bit for bit.
    .hdf5 or .h5: FCLIB's, its local form where only W is known, otherwise its global form.

    An existing file is replaced. Errors: InputError for another suffix, and where FCLIB's format cannot hold the problem (an
    LCP, a friction bias); OSError where the file cannot be written.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2).problem()
    >>> save(problem, "stack.npz")
    >>> load("stack.npz").hash == problem.hash
    True
    """
    require_problem(problem)
    path = Path(path)
    if path.suffix == ".npz":
        own.save(problem, path)
    elif path.suffix not in HDF5_SUFFIXES:
        raise InputError(f"path: {path} must end in .npz, {' or '.join(HDF5_SUFFIXES)}")
    elif isinstance(problem, LCP):
        raise InputError("problem: FCLIB's format does not hold LCPs; write an .npz")
    else:
        fclib.write(problem, path)
