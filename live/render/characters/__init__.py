"""Characters from glTF and VRM files. Imports are limited as in `render`."""
