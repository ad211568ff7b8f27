"""Georibbon: from what a ribbon of sensors measures to the surface it was laid on."""

__version__ = "0.1.0"
