"""Properties of a friction problem that do not depend on the solver: labels, stability, the census of its solutions."""
