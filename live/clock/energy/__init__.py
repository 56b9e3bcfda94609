"""What music is like, beat for beat: how loud, dense and bright it is, whether it builds up, and when it drops."""
