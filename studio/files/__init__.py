"""Files that a person keeps or brings: projects, bundles, rollouts, pictures."""
