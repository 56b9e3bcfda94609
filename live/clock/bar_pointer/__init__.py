"""The bar pointer: activations in; tempo, beat, metre and downbeat out, filtered forward (Whiteley, Krebs, Böck)."""
