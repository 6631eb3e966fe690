"""The contract between the suite and a solver, as checks that say what is wrong and what to do: `frictionbench check-solver`.

One file a group of checks, each a function that yields its complaints; harness.contract.check has what they share.
"""
