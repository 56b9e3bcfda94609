"""The operator's page and its server. It may import what `control` may."""
