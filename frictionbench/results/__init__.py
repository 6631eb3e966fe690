"""What a run stores: tables with their schema, files beside them, and the comparison of two runs."""
