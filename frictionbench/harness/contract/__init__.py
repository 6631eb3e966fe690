"""The contract of a solver as checks that report what is wrong and how to correct it: `frictionbench check-solver`.

One file for each group of checks, each check a function that yields violations; harness.contract.check has what they share.
"""
