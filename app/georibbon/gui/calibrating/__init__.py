"""The page that calibrates: poses as pictures, live stillness, quality, and what is kept."""
