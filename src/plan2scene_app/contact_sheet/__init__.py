"""The contact sheet: a picture of what each step from photo to crops found."""
