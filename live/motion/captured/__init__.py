"""Captured bodies: real dancers' skeletons as they come over the network, onto the engine's and into its dancers."""
