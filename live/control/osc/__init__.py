"""Open Sound Control and OSCQuery: sockets, packets, schedule, answers. It may import what `control` may."""
