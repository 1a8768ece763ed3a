"""Training and evaluation without the page, in run directories that can be resumed."""
