"""Motion by example while the leader moves: units are scored while they are danced, and answered before they end."""
