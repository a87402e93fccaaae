"""The application: command line, run, studio, editor, viewer, tracing, plan formats, exports."""
