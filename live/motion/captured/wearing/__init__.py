"""Wearing: captured poses on dancers."""
