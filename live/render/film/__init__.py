"""Video, streams, shared memory."""
