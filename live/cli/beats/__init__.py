"""Commands about beats: what is heard in a sound, and how well a clock follows. It may import every layer."""
