"""The table of all controls, one file for each part of a show; `live.control.registry` puts them together."""
