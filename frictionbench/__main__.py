"""`python -m frictionbench` is the command line."""

from frictionbench.harness.cli import main

if __name__ == "__main__":
    main()
