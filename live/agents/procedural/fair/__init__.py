"""Fair attraction: the many voices of an audience (T106)."""
