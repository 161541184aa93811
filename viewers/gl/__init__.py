"""The parts of the OpenGL renderer: context, programs, figures, marks, targets."""
