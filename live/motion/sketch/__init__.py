"""Steps written as text."""
