"""Editing a scene: pointer, selection, undo, and the verdict on its formula."""
