"""Readings to curves: each pass by itself, then all passes with the survey."""
