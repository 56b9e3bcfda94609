"""Pictures and models from files and live inputs for the scenography."""
