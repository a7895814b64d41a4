"""Views: Designer forms with setters and signals, without logic."""
