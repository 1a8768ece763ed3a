"""How the gait that ships was made: `python -m envs.ant.gait_training`; nothing imports it."""
