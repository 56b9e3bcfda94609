"""What is asked of every agent before anybody asks, and who is there."""
