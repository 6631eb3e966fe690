"""Contact-wise methods: the form of the problem, the law at one contact, sweeps, gradient steps and stopping criteria."""
