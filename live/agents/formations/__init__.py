"""Formations: how a group occupies the stage; shape, density, pattern, symmetry, soloists, sections (T090-T093, T144).

`spec.FormationSpec` says what is wanted, `formation.formation_of` gives the places. `spec_table` reads and writes
tables of TOML or JSON, `spec_words` reads short words.
"""
