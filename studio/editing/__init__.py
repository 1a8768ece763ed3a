"""The scene that is being edited: pointer, selection, undo, and its formula judged."""
