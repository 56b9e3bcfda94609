"""The choice of the next measure: every dancer's edges, each with its clip and mixtures, weighed in one kernel."""
