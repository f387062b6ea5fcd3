"""Studies: tables of cases, figures, claims and pages, and the engine that computes, draws and judges them."""
