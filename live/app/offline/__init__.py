"""Work without a live show: films, dances, partners, steps, soaks and reports, computed for a command.

It may import every layer but `cli`.
"""
