"""The command line: `cli` defines the commands, and other files hold the work that is specific to one command."""
