"""The parts of the PyVista viewer: plotter, what stands in it, pictures, window, notebook."""
