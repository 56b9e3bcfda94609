"""Scripts that write what the project keeps: references, pictures, music."""
