"""The show: what happens in which measure, the frame loop, the journal and its replay."""
