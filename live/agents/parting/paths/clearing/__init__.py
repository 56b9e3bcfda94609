"""What stands on the stage keeps out whoever is carried beyond her step."""
