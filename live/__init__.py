"""ChoreoGraphics Live: a real-time engine for dancing with virtual dancers."""

__version__ = "0.1.0"
