"""One module per panel of the app; each builds its part from the session and keeps no state of its own."""
