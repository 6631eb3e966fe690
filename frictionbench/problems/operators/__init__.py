"""The contact operators: the map u = W r + q from contact impulses to contact velocities, known by mechanics or by W alone."""
