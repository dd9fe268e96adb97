"""The run record on disk and the HTML page that is a view of it."""
