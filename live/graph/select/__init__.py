"""Live selection of the next measure: candidates, scores, reachability. It may import what `graph` may."""
