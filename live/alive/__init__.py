"""What keeps a show alive: processes that watch one another, and the log from which another engine goes on."""
