"""The page that connects a ribbon, and what shows how it does: raw view, health, virtual hands."""
