"""motionloom's studio: everything a person touches, the app in the browser and the command line."""
