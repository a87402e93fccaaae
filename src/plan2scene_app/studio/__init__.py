"""The studio: a local server to draw a plan, add photos, make the house and look at it."""
