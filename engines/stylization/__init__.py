"""Generative motion stylization in a latent space: the same movement in another manner (thesis, chapter 5)."""
