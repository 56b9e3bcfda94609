"""The state of a show as data: what is in it, field by field; its writing and reading."""
