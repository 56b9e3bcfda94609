"""The generated body: mesh, weights, levels of detail. It may import what `render` may."""
