"""Published results: summaries of runs, and a static site of them. `python -m tools.publish --help` shows the options."""
