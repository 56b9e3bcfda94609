"""The group on the floor: agents, what moves them, and one fixed-timestep advance for all."""
