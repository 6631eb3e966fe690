"""Values of the columns `scheme`, `start`, `after_failure` and `phase` (results.schema), for writers and readers."""

DEFAULT_SCHEME = "anitescu_potra"  # of time stepping, where none is named
COLD, WARM, SHUFFLED = "cold", "warm", "shuffled"  # starts: zero; the impulses before; impulses drawn from the whole motion
KEEP_ANSWER, KEEP_VELOCITY, RELAX = "answer", "velocity", "relaxation"  # what moves the bodies after a failed step


def first_phase(scheme: str) -> str:
    """The phase of the first problem that a scheme meets."""
    return "step" if scheme == DEFAULT_SCHEME else f"step of {scheme}"
