"""Entry points of the processes of a show: engine, standby, audio, OSC reader and fallback window.

It may import every layer but `cli`.
"""
