"""Study of Chen, Jiang, Deng and Wang (2018) on the nine-bar mechanism: tables of cases, figures, claims and pages."""
