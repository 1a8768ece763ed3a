"""The grounded MDP (Sec. 4.2) and its modes."""
