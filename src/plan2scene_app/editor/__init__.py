"""The plan editor: one offline page that draws plans and assigns photos to rooms."""

from plan2scene_app.editor.page import editor_page, write_editor

__all__ = ["editor_page", "write_editor"]
