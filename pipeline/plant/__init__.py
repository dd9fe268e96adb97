"""The seam: everything above this room knows a plant only through it, and only this room imports fmpy."""
