"""Construction of the graph: distances between poses, transitions, blends. It may import what `graph` may."""
