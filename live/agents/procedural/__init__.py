"""Procedural elements: what acts on the dancers without saying where each of them shall be (T105-T110, T132)."""
