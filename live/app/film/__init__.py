"""Films: of a show or a journal offline, and of a running show; and its dancers' motion in files."""
