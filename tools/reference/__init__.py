"""The reference pages of the documentation, made from the program's own tables when the site is built."""
