"""A library's options, apart from tolerances and work limits: as a user gets them, and as its documentation allows.

An adapter sets tolerances and work limits for every problem, as a user would have to. Where another option of the library
makes a difference, the adapter has a field `settings`: `default` leaves the option alone, `tuned` sets it, and the entry
`Settings` in the docstring of its file names the option and both values. Both are variants with rows of their own.
"""

from frictionbench.problems.check import require


def require_settings(chosen: str, tunable: bool = True) -> None:
    """Errors: InputError naming settings where the choice is neither default nor, if there is an option to set, tuned."""
    known = ("default", "tuned") if tunable else ("default",)
    require(chosen in known, "settings", f"must be {' or '.join(known)}, got {chosen!r}")
