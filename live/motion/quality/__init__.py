"""Figures of a motion's quality, one implementation for reports and benches: feet, smoothness of joins, beats."""
