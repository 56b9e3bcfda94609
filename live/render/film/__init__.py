"""Pictures for files and other programs: video, streams, shared memory. It may import what `render` may."""
