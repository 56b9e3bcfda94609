"""Control reads what people and machines send, within bounds, and hands it over as events.

It may import `motion`, `clock` and `base`, and knows neither `render` nor the simulation.
"""
