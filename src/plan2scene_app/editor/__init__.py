"""The plan editor: one offline page that draws plans and assigns photos to rooms."""
