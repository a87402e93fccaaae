"""The studio: a local web server to draw a plan, add photos, make the house and view it."""
