"""The moving pictures of the documentation: what each one shows, and how it is drawn from the engine."""
