"""A formula grounded in a robot's world: data that compiled programs take."""
