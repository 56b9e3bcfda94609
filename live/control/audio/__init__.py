"""Sound devices: input, output, and the delay between them. It may import what `control` may."""
