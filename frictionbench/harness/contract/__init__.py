"""The contract of a solver as checks that report what is wrong and how to correct it: `frictionbench check-solver`.

checks has the checks, each a function that yields violations; check has what they share; examine runs them isolated.
"""
