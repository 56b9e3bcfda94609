"""Corrections aimed anew within the measure: by what agents strayed, and smoothly from tick to tick."""
