"""The stages of an experiment in their order, and the run record they fill."""
