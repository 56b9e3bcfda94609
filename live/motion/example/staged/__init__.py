"""The partner on a stage: how what the online follower answers is shown by dancers of a crowd."""
