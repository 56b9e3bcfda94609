"""Several gateways for one audience: each keeps its phones, and a reducer beside the show merges what they tell."""
