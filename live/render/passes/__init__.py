"""The passes of a picture, one file each, in the order in which the renderer runs them."""
