"""Frame output to files and other programs: video, streams, shared memory. It may import what `render` may."""
