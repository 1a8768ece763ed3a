"""Plans whose robustness is proved to be the largest, for robots that move by bounded strides."""
