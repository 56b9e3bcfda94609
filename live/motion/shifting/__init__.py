"""Translation insertion: a dancer is carried beyond her step while a foot is in the air (after T048-T050)."""
