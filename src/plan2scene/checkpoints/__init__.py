"""The authors' released checkpoints: read without running anything in them, converted to ours."""
