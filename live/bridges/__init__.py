"""Bridges: optional inputs and outputs, a package each. Nothing imports them; `live.app.bridges` finds them.

May import every layer except `cli`.
"""
