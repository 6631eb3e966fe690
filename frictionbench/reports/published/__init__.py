"""Published results: the summary of a run as text, and a static site of runs, machine beside machine."""
