"""The contract of a solver as checks that report violations and how to correct them: `frictionbench check-solver`.

`checks` holds the checks, each a function that yields violations, `check` what they share, and `examine` runs them isolated.
"""
