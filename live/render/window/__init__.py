"""Windows and monitors. Imports are limited as in `render`."""
