"""Dense arrays named by the usual letters, as written by np.savez("problem.npz", M=M, N=N, T=T, mu=mu, v=v, b=b):

    M, N, T, mu, v (also vfree), with b, fb, F, bF, d    masses and Jacobians (docs/recorded.md has the shapes and defaults)
    W, q, mu, d, with fb                                 u = W r + q, rows per contact, normal first
    M (n, n), q (n)                                      an LCP, w = M z + q
    G (3 nc, 3 nc), g (3 nc, 1), mus (nc)                u = G r + g of ContactBench (Le Lidec and others 2024)

ContactBench's contacts have the normal last, (t1, t2, n). Its G includes a compliance of 1e-9 I, which is part of the problem.
"""

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from frictionbench.problems import sizes
from frictionbench.problems.check import Array, require
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.archive import in_letters, require_known

Arrays = dict[str, Array]

# The letters of the fields of a FrictionProblem, and of its Delassus form.
BODIES = {
    "normal": "N",
    "tangent": "T",
    "mass": "M",
    "free_velocity": "v",
    "friction": "mu",
    "bias": "b",
    "friction_bias": "fb",
    "joints": "F",
    "joint_bias": "bF",
    "dimension": "d",
}
DELASSUS = {"W": "W", "q": "q", "friction": "mu", "friction_bias": "fb", "dimension": "d"}
CONTACTBENCH = {"W": "G", "q": "g", "friction": "mus", "dimension": "d"}
STATED_ROUNDING = 1e-6  # relative to the largest entry: W and q stored with M, N and T may differ by this, because of rounding


def kind(arrays: Arrays) -> Callable[[Arrays], FrictionProblem | LCP] | None:
    """The function that reads these arrays, None if they are of none of these kinds."""
    names = arrays.keys()
    if {"G", "g", "mus"} <= names:
        return contactbench
    if names & {"N", "T"}:
        return mechanical
    if "W" in names:
        return known_by_delassus
    return lcp if {"M", "q"} <= names else None


def mechanical(arrays: Arrays) -> FrictionProblem:
    """A problem given by masses and contact rows. Errors: InputError naming the array."""
    require_known(arrays, {*BODIES.values(), "vfree", "W", "q"})
    require(not {"v", "vfree"} <= arrays.keys(), "vfree", "another name of v, which is given as well")
    require("F" in arrays or "bF" not in arrays, "bF", "given without F")
    letters = BODIES | ({"free_velocity": "vfree"} if "vfree" in arrays else {})
    for letter in (letters[field] for field in ("mass", "normal", "tangent", "friction", "free_velocity")):
        require(letter in arrays, letter, "missing")
    d = _dimension(arrays, default=2)
    fields: dict[str, Any] = {field: arrays.get(letter) for field, letter in letters.items() if field != "dimension"}
    normal, tangent = _by_rows(arrays["N"], arrays["T"], [*arrays["M"].shape, arrays[letters["free_velocity"]].size])
    fields |= {"normal": normal, "tangent": tangent}
    with in_letters(letters):
        sizes.agree(d, fields, letters | ({} if "d" in arrays else {"dimension": "d, which is left out,"}))
        nc = len(normal)
        fields |= {"friction": _for_each(arrays["mu"], nc), "bias": arrays.get("b", np.zeros(nc))}
        problem = FrictionProblem(**fields, dimension=d)
    _compare(problem, arrays)
    return problem


def known_by_delassus(arrays: Arrays) -> FrictionProblem:
    """A problem in Delassus form. Errors: InputError naming the array."""
    require_known(arrays, set(DELASSUS.values()))
    for letter in ("q", "mu", "d"):
        require(letter in arrays, letter, "missing")
    d, fields = _dimension(arrays), {field: arrays.get(letter) for field, letter in DELASSUS.items() if field != "dimension"}
    with in_letters(DELASSUS):
        sizes.agree(d, fields, DELASSUS)
        return FrictionProblem.from_delassus(**fields | {"friction": _for_each(arrays["mu"], arrays["q"].size // d)}, d=d)


def contactbench(arrays: Arrays) -> FrictionProblem:
    """ContactBench's problem with the normal first. Errors: InputError naming the array."""
    require_known(arrays, ("G", "g", "mus", "lam0"))
    G, g, mu = arrays["G"], arrays["g"].ravel(), arrays["mus"].ravel()
    require(G.ndim == 2, "G", f"expected a matrix, got shape {G.shape}")
    sizes.agree(3, {"W": G, "q": g, "friction": mu}, CONTACTBENCH)
    order = (3 * np.arange(mu.size)[:, None] + np.array([2, 0, 1])).ravel()
    with in_letters(CONTACTBENCH):
        return FrictionProblem.from_delassus(G[np.ix_(order, order)], g[order], mu, 3)


def lcp(arrays: Arrays) -> LCP:
    """A bare LCP. Errors: InputError naming the array."""
    require_known(arrays, {"M", "q"})
    M, q = arrays["M"], arrays["q"]
    require(M.ndim != 2 or M.shape == (q.size, q.size), "M", f"expected shape {(q.size, q.size)} as q has, got {M.shape}")
    return LCP(M, q)


def _by_rows(N: Array, T: Array, velocities: list[int]) -> tuple[Array, Array]:
    """N and T with the contacts in rows. velocities: the sizes of M and v, of which the most frequent that fits is nv.

    Errors: InputError naming the array that is not a matrix, or that has contacts in columns while the other has rows.
    """
    for name, matrix in {"N": N, "T": T}.items():
        require(matrix.ndim == 2, name, f"expected a matrix, got shape {matrix.shape}")
    for nv, _ in Counter(velocities).most_common():
        in_rows, in_columns = ([matrix.shape[axis] == nv != matrix.shape[1 - axis] for matrix in (N, T)] for axis in (1, 0))
        if any(in_rows) or any(in_columns):
            columns, other = ("N", "T") if in_columns[0] else ("T", "N")
            require(not (any(in_rows) and any(in_columns)), columns, f"has its contacts in columns, and {other} in rows")
            return (N.T, T.T) if any(in_columns) else (N, T)
    return N, T


def _for_each(mu: Array, nc: int) -> Array:
    return np.full(nc, mu) if mu.ndim == 0 else mu


def _compare(problem: FrictionProblem, arrays: Arrays) -> None:
    """Errors: InputError naming W or q if it is given in addition to masses and contact rows, and differs from theirs."""
    for name in ("W", "q"):
        if name in arrays:
            stated, n = arrays[name], len(problem.q)
            shape = (n, n) if name == "W" else (n,)
            require(stated.shape == shape, name, f"expected shape {shape} as of the bodies, got {stated.shape}")
            computed = problem.W.toarray() if name == "W" else problem.q
            off, most = (float(np.abs(part).max(initial=0.0)) for part in (stated - computed, computed))
            reason = f"differs from that of the bodies by up to {off:.2g}; give one of the two"
            require(off <= STATED_ROUNDING * most, name, reason)


def _dimension(arrays: Arrays, default: int = 0) -> int:
    d = arrays.get("d", np.array(default))
    require(d.size == 1 and d.ravel()[0] in (2, 3), "d", f"must be 2 or 3, got {d}")
    return int(d.ravel()[0])
