"""Virtual captures: recordings of a virtual ribbon on known surfaces, with their truth."""
