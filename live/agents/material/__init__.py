"""Group motion as material: formations and evolutions bent and squeezed elsewhere with neighbours kept (T145).

It may import what `agents` may.
"""
