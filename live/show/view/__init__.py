"""What others see of a show: drawing snapshot, scene, debug overlay, status figures, published values.

It may import what `show` may."""
