"""The audience's phones: HTTP server, sessions, fair shares, votes. It may import what `control` may."""
