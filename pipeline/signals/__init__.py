"""Filters, derivatives and decimation of sampled signals."""
