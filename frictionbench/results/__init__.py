"""The results of a run: tables with their schema, further files, and the comparison of two runs."""
