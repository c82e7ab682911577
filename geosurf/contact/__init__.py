"""Which triangles meet, and in which named points."""
