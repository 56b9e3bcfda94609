"""The generated body: mesh, skin weights, levels of detail. Imports are limited as in `render`."""
