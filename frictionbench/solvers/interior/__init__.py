"""Interior point methods: the scaled system, its points, Newton steps, and the methods that iterate them."""
