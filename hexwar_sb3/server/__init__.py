"""`hexwar play`: one game for one person, in a browser on this machine (formats/play.md)."""
