"""A few small kernels, to try in a second what the real ones do in a minute."""
