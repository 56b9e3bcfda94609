"""Show network: pairing, leadership and standby machines. It may import whatever `supervisor` may."""
