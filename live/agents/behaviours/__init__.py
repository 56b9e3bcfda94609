"""Reynolds' behaviours of one agent: what she wants of her own motion, before neighbours are looked at."""
