"""How much sharper than tol a library is asked to be where its own measure is looser than the project's.

The project's residual is the largest defect of one contact, as a velocity. A library stops by its own measure: a sum, a mean
or a norm of scaled rows, primal and dual apart. An answer that just meets that can miss tol by a small factor and be called
missed for a difference of norms, which says nothing of the method. A tenth of tol is asked for instead, of every library alike
whose measure was seen to fall short; interior points that overshoot anyway, and libraries that test the very residual, are
asked for tol itself.
"""

MARGIN = 10
