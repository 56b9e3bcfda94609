"""Sound of a show: soundtrack of a film, click, Link. It may import what `show` may."""
