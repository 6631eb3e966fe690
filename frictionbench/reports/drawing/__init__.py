"""The style of figures, their panels and files, and the format of names and numbers."""
