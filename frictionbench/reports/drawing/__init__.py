"""How figures look, what they are drawn on, and how names and numbers are written."""
