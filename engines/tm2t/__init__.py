"""TM2T: text to motion and motion to text over motion tokens (Guo et al., ECCV 2022; thesis chapter 6)."""
