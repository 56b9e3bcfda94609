"""Windows and monitors. It may import what `render` may."""
