"""Commands that inspect a patch or a journal: check, score, contact sheet, formation. They may import every layer."""
