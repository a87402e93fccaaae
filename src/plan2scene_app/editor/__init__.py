"""The plan editor: an offline page in which plans are drawn and photos are assigned to rooms."""
