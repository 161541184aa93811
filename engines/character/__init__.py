"""A photo becomes a rigged, textured body: landmarks and mask, a body fitted to them, a surface, its colours, a rig.

After the step motion2video of "Generative Modeling of 3D Human Actions" (thesis, section 3.2.2). No viewer is imported
here: the parametric body is passed in.
"""
