"""Release: version, changelog, built files and their checks, sums, parts and licences. `make release VERSION=0.2.0`."""
