"""Foreign skeletons onto ours."""
