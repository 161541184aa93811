"""The browser player: one three.js bundle for Jupyter, Panel and plain HTML pages."""
