"""Selection of the next measure, live: candidates, scores, reachability. It may import what `graph` may."""
