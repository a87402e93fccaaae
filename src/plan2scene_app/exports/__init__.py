"""Exports of a house to other programs: USD, simulators, IFC, ROS maps, plans, OBJ."""
