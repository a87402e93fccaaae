"""The user study: its sheets, form and answers."""
