"""Values of the columns `scheme`, `start`, `after_failure`, `phase` and `way` (results.schema) and the settings of batches,
for writers and readers."""

DEFAULT_SCHEME = "anitescu_potra"  # of time stepping, where none is named
COLD, WARM, SHUFFLED = "cold", "warm", "shuffled"  # starts: zero; the impulses before; impulses drawn from the whole motion
KEEP_ANSWER, KEEP_VELOCITY, RELAX = "answer", "velocity", "relaxation"  # what moves the bodies after a failed step

DRAWN = {"push": (0.2, 2.0), "friction": (0.2, 0.8), "mass_ratio": (1.0, 10.0)}  # of each problem of a batch, the bounds
NEARBY = 0.02  # by how much smaller the push is, in whose answers a batch starts warm
WAYS = {  # of solving all problems of a batch, with their meanings
    "calls": "a call of `solve` for each",
    "packed": "`solve_many` over a Batch, which is packed already",
    "list": "`solve_many` over a list of problems",
    "kernel": "the library's own kernel called in a compiled loop, on dense matrices made beforehand",
    "kernel from bodies": "the same with this package's form before each call and its residual after it",
}


def first_phase(scheme: str) -> str:
    """The phase of the first problem that a scheme meets."""
    return "step" if scheme == DEFAULT_SCHEME else f"step of {scheme}"
