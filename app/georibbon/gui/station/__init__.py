"""The ribbon that is connected, real or virtual, as the window's pages see it."""
