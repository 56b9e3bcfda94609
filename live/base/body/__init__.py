"""What dancers look like: bodies, characters, faces and hands. Imports are limited as in `base`."""
