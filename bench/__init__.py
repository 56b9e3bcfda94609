"""Benches: one file for each group of figures; `live bench NAME` runs them."""
