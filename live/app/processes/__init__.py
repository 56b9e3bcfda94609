"""Entry points of a show's processes: engine, standby, audio, OSC reader and fallback window.

May import every layer except `cli`.
"""
