"""The ribbon on its cable: packets, the link that survives what cables do, stillness."""
