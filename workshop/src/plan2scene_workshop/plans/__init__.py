"""Drawn plans of synthetic homes, and the network that reads them."""
