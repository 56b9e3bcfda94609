"""Commands that look at a patch or a journal: check, score, contact sheet, formation. It may import every layer."""
