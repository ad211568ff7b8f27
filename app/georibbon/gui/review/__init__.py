"""What is done with a capture afterwards: looking through it, comparing, exporting."""
