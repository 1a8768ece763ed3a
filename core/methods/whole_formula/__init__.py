"""What the baselines (Sec. 5.1, App. A.3) share: they carry out a formula as a whole."""
