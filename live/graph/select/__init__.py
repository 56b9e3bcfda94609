"""Next measure, live."""
