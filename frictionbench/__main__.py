"""`python -m frictionbench` is the command line."""

import sys

from frictionbench.harness.cli import main

if __name__ == "__main__":
    sys.exit(main())
