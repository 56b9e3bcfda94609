"""The motion graph defines which step can follow which; the next step is chosen from it at each measure.

It may import `motion`, `clock` and `base`.
"""
