"""The contact sheet: what became of each photo on the way to crops."""
