"""The figures of the source paper as pictures, a table and a page."""
