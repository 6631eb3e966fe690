"""The work inside a worker process: collecting problems, solving and simulating cells, making rows."""
