"""The tables of a patch, one file for each part of a show; `live.show.patch` puts them together."""
