"""Linear complementarity by bases: scaling, bases and their updates, and the paths that pivot along them."""
