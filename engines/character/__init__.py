"""A photo becomes a rigged, textured body: what is seen of a person, a body fitted to it, a surface, its colours, a rig.

After the step motion2video of "Generative Modeling of 3D Human Actions" (thesis, section 3.2.2). No viewer is imported
here: the parametric body is passed in.
"""
