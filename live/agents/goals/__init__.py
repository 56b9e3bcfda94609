"""Goals are the places that agents go to, one after another. It may import what `agents` may."""
