"""What people touch: command line, run, studio, editor, viewer, tracing, plan formats, exports."""
