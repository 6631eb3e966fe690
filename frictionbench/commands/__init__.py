"""The command line: its commands in cli, and what a command does beyond other folders in a file of its own."""
