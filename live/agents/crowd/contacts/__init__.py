"""Contacts: bodies that come too near are kept apart, whatever was wanted."""
