"""Ceiling heights and windows of houses whose plans do not give them, measured in photos."""
