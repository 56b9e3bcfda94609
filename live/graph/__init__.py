"""The motion graph says which step can follow which, and chooses the next one at each measure.

It may import `motion`, `clock` and `base`.
"""
