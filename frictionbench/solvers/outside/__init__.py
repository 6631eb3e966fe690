"""Adapters of outside libraries: each converts a problem, asks for a tolerance of one meaning, and converts the answer.

An adapter sets tolerances and work limits for every problem, as a user would have to. Where another option of the library
makes a difference, the adapter has a field `settings`: `default` leaves the option alone, `tuned` sets it as the library's
documentation allows, and the entry `Settings` in its docstring names the option and both values. Both are variants with rows of
their own.

The residual is the largest error of one contact, as a velocity. A library stops by its own criterion: a sum, a mean or a norm
of scaled rows, primal and dual separately. An answer that just meets it can exceed tol by a small factor and be a near miss for
a difference of norms, which says nothing about the method. Every library whose criterion was seen to be weaker is therefore
asked for tol over MARGIN; interior points, which overshoot, and libraries that test this very residual get tol itself.
"""

MARGIN = 10  # larger than every factor that was seen
