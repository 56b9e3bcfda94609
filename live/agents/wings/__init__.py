"""Wings: where dancers enter the stage and leave it while the show runs."""
