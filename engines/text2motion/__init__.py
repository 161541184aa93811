"""Text2Motion: sentences become motions of the length they call for (Guo et al. 2022; thesis chapter 4)."""
