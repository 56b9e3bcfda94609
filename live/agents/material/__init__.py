"""Group motion as material: formations and evolutions moved, bent and squeezed elsewhere with neighbours kept (T145)."""
