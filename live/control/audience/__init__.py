"""Audience phones: HTTP server, sessions, fair shares and votes. It may import what `control` may."""
