"""TGPO and TGPO*: one time-conditioned policy, and a critic that searches the times."""
