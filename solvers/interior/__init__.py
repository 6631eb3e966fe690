"""Interior point methods: the scaled system, its points and Newton steps, and the paths through the interior."""
