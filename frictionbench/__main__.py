"""`python -m frictionbench` is the command line."""

from frictionbench.commands.cli import main

if __name__ == "__main__":
    main()
