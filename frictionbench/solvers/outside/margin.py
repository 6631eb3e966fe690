"""The factor between tol and the tolerance of a library whose stopping criterion is weaker than the residual.

The residual is the largest error of one contact, as a velocity. A library stops by its own criterion: a sum, a mean or a norm
of scaled rows, primal and dual separately. An answer that just meets it can exceed tol by a small factor and be a near miss for
a difference of norms, which says nothing about the method. Every library whose criterion was seen to be weaker therefore gets
a tenth of tol; interior points, which overshoot, and libraries that test this very residual get tol itself.
"""

MARGIN = 10  # larger than every factor that was seen
