"""Files that a user saves or opens: projects, bundles, rollouts, pictures."""
