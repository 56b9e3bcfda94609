"""Commands that inspect a patch or a journal: check, schema, score, sheet, formation. They may import every layer."""
