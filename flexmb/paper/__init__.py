"""The study of Chen, Jiang, Deng and Wang (2018) on the nine-bar mechanism, computed anew: cases, figures, claims."""
