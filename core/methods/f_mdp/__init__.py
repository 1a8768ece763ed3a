"""F-MDP: the state has a flag for each subformula (App. A.3)."""
