"""The virtual ribbon: what a ribbon on a real object would say, through a real port."""
