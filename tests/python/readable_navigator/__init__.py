"""The measurement of a pose as it can be read, in numpy: what the core's is held against."""
