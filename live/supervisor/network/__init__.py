"""The show network: pairing, claims and standbys on other machines. It may import what `supervisor` may."""
