"""Names of what dancers wear and how their hair is; a dancer's appearance is one row of whole numbers."""

from typing import Final

BODY: Final = 0
"""Column of an appearance: the body, by its place among those of the scene, …"""
SKIN: Final = 1
"""… the skin's tone from 0 (darkest) to 255 (palest), …"""
HAIR: Final = 2
"""… the hair style, by its place in `HAIRS`, …"""
HAIR_COLOUR: Final = 3
"""… the hair's colour from 0 (black) to 255 (white), …"""
COSTUME: Final = 4
"""… the costume, by its place in `COSTUMES`, …"""
SHOES_WORN: Final = 5
"""… and the shoes, by their place in `SHOES`."""
APPEARANCE_SIZE: Final = 6
"""Number of columns."""
BY_CHANCE: Final = -1
"""In a column: the renderer chooses, the same for a dancer of that number in every show (the body: as in the scene)."""
DEFAULT_APPEARANCE: Final = (BY_CHANCE, BY_CHANCE, 0, BY_CHANCE, 0, 0)
"""The appearance of a dancer of whom nothing is said."""

HAIRS: Final = ("usual", "bun", "bald", "crop", "bob", "ponytail", "long", "curls", "braid")
"""Hair styles; the first is the default: short hair for men, a bun for all others."""
COSTUMES: Final = ("leotard", "unitard", "trousers", "dress", "skirt", "jacket", "bare")
"""Costumes; the first is the default. `bare`: shorts, and for women a top."""
FABRICS: Final = ("cotton", "silk", "wool", "tulle")
"""What skirts and sleeves are made of; the first is the default."""
EXTRAS: Final = ("none", "sleeves", "ribbons", "sleeves and ribbons")
"""What dancers wear on their arms or carry; the first is the default."""
MOVING: Final = ("auto", "skinned")
"""How skirts, sleeves, ribbons and long hair move: by simulation as far as there is time, or fixed to the body."""
SHOES: Final = ("barefoot", "ballet", "pumps", "sneakers", "boots")
"""What dancers have on their feet; the first is the default."""
