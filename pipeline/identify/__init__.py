"""Estimators: arrays in, records out."""
