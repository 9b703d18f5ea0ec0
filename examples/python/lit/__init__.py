"""The rows of the table of what a texture can be, one function each."""
