"""`tgpo-bench`: many trainings from one file, kept run by run, and a report on them."""
