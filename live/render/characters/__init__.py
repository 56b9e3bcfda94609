"""Characters that people bring: glTF and VRM files. It may import what `render` may."""
