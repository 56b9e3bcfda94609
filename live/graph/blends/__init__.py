"""Whether one clip can be blended into another: rotations that lie too far apart have no way between them."""
