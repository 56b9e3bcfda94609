"""Example-based offline synthesis of a partner's motion (Hsu et al.). Imports only what `motion` may."""
