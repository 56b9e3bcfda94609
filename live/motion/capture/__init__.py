"""Live motion capture: poses of captured people, retargeted and smoothed. May import what `motion` may."""
