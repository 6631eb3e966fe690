"""Outside libraries called by hand, and the page on how each is treated. Only the package's public face is used."""
