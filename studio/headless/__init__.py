"""Training and evaluation without the page, in directories from which they go on."""
