"""A house in other people's tools: USD, simulators, IFC, occupancy maps."""
