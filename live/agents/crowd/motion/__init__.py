"""Motion: from what is asked of an agent to her new velocity."""
