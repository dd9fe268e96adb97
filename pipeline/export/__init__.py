"""Modelica to FMU: front end, equations, C code, model description, archive; a file each."""
