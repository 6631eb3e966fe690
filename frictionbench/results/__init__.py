"""The tables a run leaves: their schema, their store, and the comparison of two runs."""
