"""Motion texturing: detail from recordings for sketched motion (Pullen & Bregler). Imports only what `motion` may."""
