"""What people would take elsewhere: other libraries' learners and robustness, measured here."""
