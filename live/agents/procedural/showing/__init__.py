"""The elements in force as the picture shows them."""
