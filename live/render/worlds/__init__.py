"""Drawing of the worlds: what is more than the backdrop of each (`shaders/worlds`)."""
