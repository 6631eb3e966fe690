"""Outside libraries called by hand, and the page of how each is treated; through the package's public face only."""
