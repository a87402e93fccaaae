"""The user study: its sheets, its form and the evaluation of the answers."""
